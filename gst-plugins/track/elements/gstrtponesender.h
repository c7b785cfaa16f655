/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_RTP_ONE_SENDER (gst_rtp_one_sender_get_type())
G_DECLARE_FINAL_TYPE(GstRtpOneSender, gst_rtp_one_sender, GST, RTP_ONE_SENDER, GstBin)

GST_ELEMENT_REGISTER_DECLARE(rtponesender)

G_END_DECLS
