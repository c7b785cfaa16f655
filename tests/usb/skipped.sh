#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
echo "skipped: umockdev is not installed (libumockdev-dev, umockdev)"
exit 77
