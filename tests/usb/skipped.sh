#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
echo "SKIPPED: umockdev is not installed (libumockdev-dev, umockdev)"
exit 77
