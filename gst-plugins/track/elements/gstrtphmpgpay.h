/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/rtp/gstrtpbasepayload.h>

G_BEGIN_DECLS

#define GST_TYPE_RTP_HMPG_PAY (gst_rtp_hmpg_pay_get_type())
G_DECLARE_FINAL_TYPE(GstRtpHmpgPay, gst_rtp_hmpg_pay, GST, RTP_HMPG_PAY, GstRTPBasePayload)

GST_ELEMENT_REGISTER_DECLARE(rtphmpgpay)

G_END_DECLS
