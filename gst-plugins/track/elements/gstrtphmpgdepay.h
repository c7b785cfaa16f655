/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/rtp/gstrtpbasedepayload.h>

G_BEGIN_DECLS

#define GST_TYPE_RTP_HMPG_DEPAY (gst_rtp_hmpg_depay_get_type())
G_DECLARE_FINAL_TYPE(GstRtpHmpgDepay, gst_rtp_hmpg_depay, GST, RTP_HMPG_DEPAY, GstRTPBaseDepayload)

GST_ELEMENT_REGISTER_DECLARE(rtphmpgdepay)

G_END_DECLS
