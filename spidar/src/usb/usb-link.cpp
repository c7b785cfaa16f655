// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb/usb-link.hpp"

#include "fail.hpp"
#include "usb/usb-holder.hpp"
#include "usb/usb-protocol.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>

namespace spidar {

namespace {

constexpr int kMostStaleReplies = 16;
constexpr auto kStaleReplyTime = std::chrono::milliseconds(1); // what waits is there at once
constexpr auto kCancelTime = std::chrono::milliseconds(2);     // the kernel does it at once
constexpr auto kCloseTime = std::chrono::milliseconds(50);
// After so many exchanges with a reply owed only listening tells a late reply from a lost one.
constexpr int kMostOutOfStep = 3;
constexpr auto kLatestReply = std::chrono::milliseconds(20); // or two exchanges, if that is longer

[[noreturn]] void refuse(const UsbPlace &place, int error) {
  const std::string where = place.text();
  switch (error) {
  case LIBUSB_ERROR_ACCESS:
    fail(Cause::permission, messages::kUsbForbidden, where.c_str());
  case LIBUSB_ERROR_BUSY:
    fail(Cause::busy, messages::kUsbBusy, where.c_str(), holder_of(place.node()).c_str());
  case LIBUSB_ERROR_NO_DEVICE:
    fail(Cause::not_found, messages::kUsbUnplugged, where.c_str());
  default:
    fail(Cause::io, messages::kUsbNotOpened, where.c_str(), libusb_strerror(error));
  }
}

int libusb_error_of(int error_number) {
  switch (error_number) {
  case EACCES:
  case EPERM:
    return LIBUSB_ERROR_ACCESS;
  case ENOENT:
  case ENODEV:
  case ENXIO:
    return LIBUSB_ERROR_NO_DEVICE;
  default:
    return LIBUSB_ERROR_IO;
  }
}

} // namespace

UsbContext make_usb_context() {
  libusb_context *context = nullptr;
  if (const int error = libusb_init(&context); error != 0)
    fail(Cause::io, messages::kUsbUnusable, libusb_strerror(error));
  return UsbContext(context);
}

UsbContext make_usb_context_of_one_device() {
#if LIBUSB_API_VERSION >= 0x0100010A
  const libusb_init_option option{.option = LIBUSB_OPTION_NO_DEVICE_DISCOVERY, .value = {}};
  libusb_context *context = nullptr;
  if (const int error = libusb_init_context(&context, &option, 1); error != 0)
    fail(Cause::io, messages::kUsbUnusable, libusb_strerror(error));
  return UsbContext(context);
#else // the option would apply to every later context of the program, also another library's
  return make_usb_context();
#endif
}

std::string UsbPlace::node() const {
  std::array<char, 64> path;
  std::snprintf(path.data(), path.size(), "/dev/bus/usb/%03d/%03d", bus, address);
  return path.data();
}

std::string UsbPlace::text() const {
  return "bus " + std::to_string(bus) + " device " + std::to_string(address);
}

UsbLink::UsbLink(UsbPlace place)
    : place_(std::move(place)), context_(make_usb_context_of_one_device()) {
  open_handle();
  const int alternate = find_endpoints();
  libusb_set_auto_detach_kernel_driver(handle_.get(), 1); // no harm where there is no such thing
  if (const int error = libusb_claim_interface(handle_.get(), interface_); error != 0)
    refuse(place_, error);
  claimed_ = true;
  if (alternate != 0)
    if (const int error = libusb_set_interface_alt_setting(handle_.get(), interface_, alternate);
        error != 0)
      refuse(place_, error);
  const auto landed = [](libusb_transfer *transfer) {
    static_cast<Slot *>(transfer->user_data)->flying = false;
  };
  for (Slot *slot : {&first_, &second_, &rest_})
    prepare(*slot, kEndpointOut, landed, slot);
  const auto replied = [](libusb_transfer *transfer) {
    static_cast<UsbLink *>(transfer->user_data)->on_reply();
  };
  prepare(reply_, kEndpointIn, replied, this);
}

UsbLink::~UsbLink() {
  closing_ = true;
  const std::array slots{&first_, &second_, &rest_, &reply_};
  for (Slot *slot : slots)
    cancel(*slot);
  const auto all_landed = [&] {
    return std::none_of(slots.begin(), slots.end(), [](const Slot *slot) { return slot->flying; });
  };
  if (!wait(std::chrono::steady_clock::now() + kCloseTime, all_landed)) {
    // libusb still uses them: leak them rather than free them.
    for (Slot *slot : slots)
      if (slot->flying) [[maybe_unused]]
        const auto *leaked = slot->transfer.release();
  }
  if (claimed_)
    libusb_release_interface(handle_.get(), interface_);
}

// libusb_open() does not give the descriptor, of which the guardian needs a duplicate.
void UsbLink::open_handle() {
  file_.reset(open(place_.node().c_str(), O_RDWR | O_CLOEXEC));
  if (file_.get() < 0)
    refuse(place_, libusb_error_of(errno));
  libusb_device_handle *handle = nullptr;
  if (const int error = libusb_wrap_sys_device(context_.get(), file_.get(), &handle); error != 0)
    refuse(place_, error);
  handle_.reset(handle);
}

/// Finds the endpoints by their addresses, as others may exist. Returns the alternate setting.
int UsbLink::find_endpoints() {
  libusb_config_descriptor *raw = nullptr;
  if (const int error = libusb_get_active_config_descriptor(libusb_get_device(handle_.get()), &raw);
      error != 0)
    refuse(place_, error);
  const std::unique_ptr<libusb_config_descriptor, LibusbDeleter> configuration(raw);
  const auto has = [](const libusb_interface_descriptor &setting, unsigned char address) {
    return std::any_of(setting.endpoint, setting.endpoint + setting.bNumEndpoints,
                       [address](const libusb_endpoint_descriptor &endpoint) {
                         return endpoint.bEndpointAddress == address &&
                                (endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) ==
                                    LIBUSB_TRANSFER_TYPE_BULK;
                       });
  };
  for (int i = 0; i < configuration->bNumInterfaces; ++i) {
    const libusb_interface &interface = configuration->interface[i];
    for (int k = 0; k < interface.num_altsetting; ++k) {
      const libusb_interface_descriptor &setting = interface.altsetting[k];
      if (has(setting, kEndpointOut) && has(setting, kEndpointIn)) {
        interface_ = setting.bInterfaceNumber;
        return setting.bAlternateSetting;
      }
    }
  }
  fail(Cause::io, messages::kUsbEndpoints, place_.text().c_str());
}

void UsbLink::prepare(Slot &slot, unsigned char endpoint, libusb_transfer_cb_fn landed,
                      void *data) {
  slot.transfer.reset(libusb_alloc_transfer(0));
  if (!slot.transfer)
    fail(Cause::io, messages::kUsbMemory);
  libusb_fill_bulk_transfer(slot.transfer.get(), handle_.get(), endpoint, slot.buffer.data(), 0,
                            landed, data, 0); // who waits watches the time
}

bool UsbLink::submit(Slot &slot, int size) noexcept {
  slot.transfer->length = size;
  slot.flying = true; // before it can land
  const int error = libusb_submit_transfer(slot.transfer.get());
  if (error == 0)
    return true;
  slot.flying = false;
  gone_ = gone_ || error == LIBUSB_ERROR_NO_DEVICE;
  return false;
}

bool UsbLink::submit(Slot &slot, const Request &request) noexcept {
  std::copy(request.bytes.begin(), request.bytes.end(), slot.buffer.begin());
  return request.bytes.empty() || submit(slot, static_cast<int>(request.bytes.size()));
}

/// With room for a whole packet, a reply that is too long is seen as such and not as an overflow.
void UsbLink::listen() noexcept {
  if (!reply_.flying && !in_stalled_ && !closing_ && !gone_)
    submit(reply_, kLargestPacket);
}

void UsbLink::on_reply() noexcept {
  reply_.flying = false;
  switch (reply_.transfer->status) {
  case LIBUSB_TRANSFER_COMPLETED:
    add_reply(reply_.transfer->actual_length);
    listen();
    break;
  case LIBUSB_TRANSFER_STALL: // in the place of a reply
    add_reply(-1);
    in_stalled_ = true;
    break;
  case LIBUSB_TRANSFER_OVERFLOW:
    add_reply(-1);
    break;
  case LIBUSB_TRANSFER_NO_DEVICE:
    gone_ = true;
    break;
  default:
    break;
  }
}

void UsbLink::add_reply(int length) noexcept {
  ++replies_;
  --owed_;
  newest_length_ = length;
  if (length > 0)
    std::copy_n(reply_.buffer.begin(), length, newest_.begin());
  last_on_the_wire_ = std::chrono::steady_clock::now();
}

/// Handles what happens until `done` or the deadline. True if done.
template <class Done>
bool UsbLink::wait(Deadline deadline, Done done) noexcept {
  using std::chrono::ceil, std::chrono::microseconds;
  while (!done()) {
    const auto left = std::max<std::int64_t>(
        0, ceil<microseconds>(deadline - std::chrono::steady_clock::now()).count());
    timeval time{.tv_sec = left / 1'000'000, .tv_usec = left % 1'000'000};
    const int error = libusb_handle_events_timeout_completed(context_.get(), &time, nullptr);
    if (left == 0 || (error != 0 && error != LIBUSB_ERROR_INTERRUPTED))
      return done();
  }
  return true;
}

/// Receives the replies that have come since the last exchange.
void UsbLink::collect() noexcept {
  timeval none{};
  libusb_handle_events_timeout_completed(context_.get(), &none, nullptr);
  clear_stalled_in();
  listen();
  if (!shared_)
    owed_ = std::max(owed_, 0); // nobody asked for them
}

void UsbLink::cancel(Slot &slot) noexcept {
  if (slot.flying)
    libusb_cancel_transfer(slot.transfer.get());
}

void UsbLink::clear_stalled_in() noexcept {
  if (!std::exchange(in_stalled_, false))
    return;
  libusb_clear_halt(handle_.get(), kEndpointIn);
  listen();
}

/// Whether the packet of a landed transfer reached the controller, which then owes its replies.
bool UsbLink::went_out(Slot &slot, const Request &request) noexcept {
  if (request.bytes.empty())
    return true;
  switch (slot.transfer->status) {
  case LIBUSB_TRANSFER_STALL:
    libusb_clear_halt(handle_.get(), slot.transfer->endpoint);
    return false;
  case LIBUSB_TRANSFER_NO_DEVICE:
    gone_ = true;
    return false;
  case LIBUSB_TRANSFER_COMPLETED:
  case LIBUSB_TRANSFER_CANCELLED: // it may have gone out just before
    if (static_cast<std::size_t>(slot.transfer->actual_length) != request.bytes.size())
      return false;
    last_on_the_wire_ = std::chrono::steady_clock::now();
    return true;
  default:
    return false;
  }
}

void UsbLink::set_rest(Request packet) noexcept {
  std::copy(packet.bytes.begin(), packet.bytes.end(), rest_packet_.begin());
  rest_request_ = {{rest_packet_.data(), packet.bytes.size()}, packet.replies};
}

/// Leaves the rest packet to the kernel, so that it goes out as soon as the endpoint takes it, even
/// if this thread does not come back before.
void UsbLink::start_resting() noexcept {
  if (rest_request_.bytes.empty() || rest_.flying || gone_ || !submit(rest_, rest_request_))
    return;
  resting_ = true;
  owed_ += rest_request_.replies;
}

void UsbLink::finish_resting(Deadline deadline) noexcept {
  if (!wait(deadline, [this] { return !rest_.flying && !out_flying(); }) ||
      !std::exchange(resting_, false))
    return;
  rested_ = went_out(rest_, rest_request_);
  if (!rested_) {
    owed_ -= rest_request_.replies;
    start_resting();
  }
}

/// Waits for late replies, without asking for more. Replies that do not come are lost.
void UsbLink::listen_only(Deadline deadline) noexcept {
  const auto begin = std::chrono::steady_clock::now();
  const std::uint64_t before = replies_;
  wait(deadline, [this] { return owed_ <= 0 || !reply_.flying; });
  clear_stalled_in();
  const auto now = std::chrono::steady_clock::now();
  const auto latest = std::max<Deadline::duration>(kLatestReply, 2 * (deadline - begin));
  if (owed_ > 0 && (replies_ != before || now - last_on_the_wire_ < latest))
    return;
  owed_ = std::min(owed_, 0);
  out_of_step_ = 0;
}

bool UsbLink::exchange(Request first, Request second, std::span<std::uint8_t> reply,
                       Deadline deadline) noexcept {
  first_went_out_ = false;
  collect();
  if (gone_)
    return false;
  if (resting_ || out_flying()) {
    finish_resting(deadline);
    return false; // the packets of this exchange are older than the rest
  }
  if (out_of_step_ >= kMostOutOfStep) {
    listen_only(deadline);
    return false;
  }
  listen();
  const std::uint64_t before = replies_;
  // Owed from now on: a reply may be reported before its request.
  owed_ += first.replies + second.replies;
  const bool first_submitted = submit(first_, first);
  const bool second_submitted = first_submitted && submit(second_, second);
  const bool landed = wait(
      deadline, [&] { return !out_flying() && (reply.empty() || owed_ <= 0 || !reply_.flying); });
  if (out_flying()) {
    cancel(first_);
    cancel(second_);
    wait(std::chrono::steady_clock::now() + kCancelTime, [this] { return !out_flying(); });
    start_resting();
  }
  // Each is looked at, so that whatever stalled is made ready.
  first_went_out_ = first_submitted && !first_.flying && went_out(first_, first);
  const bool second_went_out = second_submitted && !second_.flying && went_out(second_, second);
  owed_ -= (first_went_out_ ? 0 : first.replies) + (second_went_out ? 0 : second.replies);
  clear_stalled_in();
  out_of_step_ = owed_ > 0 ? out_of_step_ + 1 : 0;
  if (out_of_step_ == kMostOutOfStep)
    start_resting(); // nothing else is sent while it listens
  if (!landed || !first_went_out_ || !second_went_out)
    return false;
  if (reply.empty())
    return true;
  if (owed_ != 0 || replies_ == before || newest_length_ != static_cast<int>(reply.size()))
    return false;
  std::copy_n(newest_.begin(), reply.size(), reply.begin());
  return true;
}

void UsbLink::drain() noexcept {
  for (int i = 0; i < kMostStaleReplies && !gone_; ++i) {
    clear_stalled_in();
    listen();
    const std::uint64_t before = replies_;
    wait(std::chrono::steady_clock::now() + kStaleReplyTime,
         [&] { return replies_ != before || !reply_.flying; });
    if (replies_ == before)
      break;
  }
  owed_ = 0;
  out_of_step_ = 0;
}

} // namespace spidar
