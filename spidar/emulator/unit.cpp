// SPDX-License-Identifier: LGPL-2.1-or-later
#include "unit.hpp"

#include <algorithm>
#include <cerrno>
#include <utility>

namespace emulator {

namespace {

constexpr std::size_t kMostWaiting = 256;

// Not known [9]: the first endpoint, the power, and the texts. An endpoint before the two in use is
// likely [8], so a host must look for them by address.
constexpr std::uint8_t kFirstEndpoint = 0x01;

constexpr std::uint8_t kVendorSpecific = 0xff;
constexpr std::uint8_t kControlPacket = 64;

enum DescriptorType { device = 1, configuration = 2, string = 3, qualifier = 6 };

// bmRequestType: standard requests to a device, an interface, an endpoint; the direction is added.
constexpr int kToDevice = 0x00;
constexpr int kToInterface = 0x01;
constexpr int kToEndpoint = 0x02;
constexpr int kFromUnit = 0x80;

enum RequestCode {
  get_status = 0,
  clear_feature = 1,
  set_feature = 3,
  get_descriptor = 6,
  get_configuration = 8,
  set_configuration = 9,
  get_interface = 10,
  set_interface = 11
};
constexpr int kEndpointHalt = 0;

constexpr std::uint8_t low(unsigned number) {
  return static_cast<std::uint8_t>(number & 0xff);
}
constexpr std::uint8_t high(unsigned number) {
  return static_cast<std::uint8_t>(number >> 8 & 0xff);
}

Bytes text(const std::string &ascii) {
  Bytes bytes = {low(static_cast<unsigned>(2 + 2 * ascii.size())), string};
  for (const char letter : ascii) {
    bytes.push_back(static_cast<std::uint8_t>(letter));
    bytes.push_back(0);
  }
  return bytes;
}

Completion failed(std::uint32_t sequence, int error) {
  return {sequence, -error, 0, {}};
}

} // namespace

Bytes device_descriptor(std::uint16_t vendor, std::uint16_t product, bool named) {
  const std::uint8_t maker = named ? 1 : 0;
  const std::uint8_t name = named ? 2 : 0;
  const std::uint8_t serial_number = 0;
  const std::uint8_t configurations = 1;
  return {18,   device,         0x00,        0x02,         kVendorSpecific, 0,
          0,    kControlPacket, low(vendor), high(vendor), low(product),    high(product),
          0x00, 0x01,           maker,       name,         serial_number,   configurations};
}

Bytes configuration_descriptor() {
  constexpr std::uint8_t kHundredMilliamperes = 50;
  constexpr std::uint8_t kBulk = 2;
  Bytes data = {9, configuration, 0 /* total, below */, 0, 1 /* interfaces */, 1 /* its value */,
                0, 0x80,          kHundredMilliamperes};
  data.insert(data.end(), {9, 4, 0, 0, 3 /* endpoints */, kVendorSpecific, 0, 0, 0});
  for (const std::uint8_t address : {kFirstEndpoint, kBulkOut, kBulkIn})
    data.insert(data.end(),
                {7, 5, address, kBulk, low(kLargestBulkPacket), high(kLargestBulkPacket), 0});
  data[2] = low(static_cast<unsigned>(data.size()));
  return data;
}

Unit::Unit(int number, Firmware firmware) : number_(number), firmware_(std::move(firmware)) {}

std::string Unit::description() const {
  return std::string("SPIDAR-G emulator, USB2.0 ") +
         (firmware_.model() == Model::simple ? "Simple" : "SH4");
}

void Unit::attach(Time now) {
  attached_ = true;
  configuration_ = 0;
  halted_in_ = halted_out_ = false;
  firmware_.report("attached", now);
}

void Unit::detach(Time now) {
  attached_ = false;
  waiting_in_.clear();
  waiting_out_.clear();
  firmware_.report("detached", now);
}

void Unit::plug(Time now) {
  plugged_ = true;
  firmware_.power_on(now);
}

void Unit::stall(bool in, std::vector<Completion> &done) {
  (in ? halted_in_ : halted_out_) = true;
  for (const Waiting &waiting : std::exchange(in ? waiting_in_ : waiting_out_, {}))
    done.push_back(failed(waiting.sequence, EPIPE));
}

void Unit::submit(const Transfer &transfer, Time now, std::vector<Completion> &done) {
  const int address = transfer.endpoint | (transfer.in ? kFromUnit : 0);
  if (transfer.endpoint == 0)
    done.push_back(control(transfer));
  else if (configuration_ != 0 && address == kBulkIn)
    submit_in(transfer, now, done);
  else if (configuration_ != 0 && address == kBulkOut)
    submit_out(transfer, now, done);
  else if (configuration_ != 0 && address == kFirstEndpoint) // takes everything, does nothing
    done.push_back({transfer.sequence, 0, static_cast<std::uint32_t>(transfer.data.size()), {}});
  else
    done.push_back(failed(transfer.sequence, ENOENT));
}

void Unit::submit_in(const Transfer &transfer, Time now, std::vector<Completion> &done) {
  if (halted_in_ || waiting_in_.size() >= kMostWaiting) {
    done.push_back(failed(transfer.sequence, halted_in_ ? EPIPE : ENOMEM));
    return;
  }
  waiting_in_.push_back({transfer.sequence, transfer.length, {}});
  collect(now, done);
}

void Unit::submit_out(const Transfer &transfer, Time now, std::vector<Completion> &done) {
  if (halted_out_ || waiting_out_.size() >= kMostWaiting) {
    done.push_back(failed(transfer.sequence, halted_out_ ? EPIPE : ENOMEM));
    return;
  }
  const auto size = static_cast<std::uint32_t>(transfer.data.size());
  waiting_out_.push_back(
      {transfer.sequence, size, Bytes(transfer.data.begin(), transfer.data.end())});
  collect(now, done);
}

bool Unit::unlink(std::uint32_t sequence) {
  const auto wanted = [&](const Waiting &waiting) { return waiting.sequence == sequence; };
  return std::erase_if(waiting_in_, wanted) + std::erase_if(waiting_out_, wanted) > 0;
}

/// Gives the firmware the packets of the waiting transfers, if it takes any.
void Unit::send_out(Time now, std::vector<Completion> &done) {
  while (!waiting_out_.empty() && firmware_.takes_packets()) {
    const Waiting transfer = std::move(waiting_out_.front());
    waiting_out_.pop_front();
    for (auto rest = std::span(transfer.data); !rest.empty();) {
      const std::size_t size = std::min(rest.size(), kLargestBulkPacket);
      firmware_.receive(rest.first(size), now);
      rest = rest.subspan(size);
    }
    done.push_back({transfer.sequence, 0, transfer.length, {}});
  }
}

void Unit::collect(Time now, std::vector<Completion> &done) {
  send_out(now, done);
  for (auto ready = due(); ready && *ready <= now; ready = due()) {
    const Firmware::Reply reply = firmware_.fetch_reply();
    if (reply.stall) {
      stall(true, done);
      return;
    }
    Waiting &transfer = waiting_in_.front();
    const std::size_t room = transfer.length - transfer.data.size();
    const std::size_t fitting = std::min(room, reply.bytes.size());
    transfer.data.insert(transfer.data.end(), reply.bytes.begin(),
                         reply.bytes.begin() + static_cast<std::ptrdiff_t>(fitting));
    // As on the wire: a transfer ends when it is full, or with a packet that is not.
    if (reply.bytes.size() >= room || reply.bytes.size() < kLargestBulkPacket) {
      const auto size = static_cast<std::uint32_t>(transfer.data.size());
      done.push_back({transfer.sequence, reply.bytes.size() > room ? -EOVERFLOW : 0, size,
                      std::move(transfer.data)});
      waiting_in_.pop_front();
    }
    send_out(now, done); // there may be room for its reply now
  }
}

std::optional<Time> Unit::due() const {
  return waiting_in_.empty() || halted_in_ ? std::nullopt : firmware_.next_reply();
}

Completion Unit::control(const Transfer &transfer) {
  Bytes data;
  const bool from_unit = (transfer.setup[0] & kFromUnit) != 0;
  if (from_unit != transfer.in || !standard_request(transfer.setup, data))
    return failed(transfer.sequence, EPIPE);
  const std::size_t wanted = transfer.setup[6] | transfer.setup[7] << 8;
  data.resize(std::min({data.size(), wanted, static_cast<std::size_t>(transfer.length)}));
  // No request that the unit knows comes with data from the host.
  const auto size = static_cast<std::uint32_t>(data.size());
  return {transfer.sequence, 0, size, std::move(data)};
}

/// Answers a request of USB 2.0, section 9.4. False if the unit does not know it.
bool Unit::standard_request(const std::array<std::uint8_t, 8> &setup, Bytes &data) {
  const int value = setup[2] | setup[3] << 8;
  const int index = setup[4] | setup[5] << 8;
  switch (setup[0] << 8 | setup[1]) {
  case (kFromUnit | kToDevice) << 8 | get_descriptor:
    return descriptor(value >> 8, value & 0xff, data);
  case (kFromUnit | kToDevice) << 8 | get_configuration:
    data = {configuration_};
    return true;
  case kToDevice << 8 | set_configuration:
    if (value > 1)
      return false;
    configuration_ = low(static_cast<unsigned>(value));
    halted_in_ = halted_out_ = false;
    return true;
  case (kFromUnit | kToInterface) << 8 | get_interface:
    data = {0};
    return index == 0;
  case kToInterface << 8 | set_interface:
    halted_in_ = halted_out_ = false;
    return value == 0 && index == 0;
  case (kFromUnit | kToDevice) << 8 | get_status:
  case (kFromUnit | kToInterface) << 8 | get_status:
    data = {0, 0};
    return true;
  case (kFromUnit | kToEndpoint) << 8 | get_status:
    if (const bool *halted = halt_of(index))
      data = {static_cast<std::uint8_t>(*halted), 0};
    return !data.empty();
  case kToEndpoint << 8 | clear_feature:
  case kToEndpoint << 8 | set_feature:
    if (bool *halted = halt_of(index); halted && value == kEndpointHalt) {
      *halted = setup[1] == set_feature;
      return true;
    }
    return false;
  default:
    return false;
  }
}

bool *Unit::halt_of(int address) noexcept {
  if (address == kBulkIn)
    return &halted_in_;
  return address == kBulkOut ? &halted_out_ : nullptr;
}

bool Unit::descriptor(int type, int index, Bytes &data) const {
  if (type == device && index == 0)
    data = device_descriptor(kVendorId, product(), true);
  else if (type == qualifier && index == 0)
    data = {10, qualifier, 0x00, 0x02, kVendorSpecific, 0, 0, kControlPacket, 1, 0};
  else if (type == configuration && index == 0)
    data = configuration_descriptor();
  else if (type == string && index == 0)
    data = {4, string, 0x09, 0x04 /* English */};
  else if (type == string && index <= 2)
    data = text(index == 1 ? "Feeling Wind" : description());
  return !data.empty();
}

} // namespace emulator
