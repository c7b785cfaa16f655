// SPDX-License-Identifier: LGPL-2.1-or-later
#include "unit.hpp"

#include "usb-protocol.hpp"

#include <algorithm>
#include <cerrno>

namespace emulator {

namespace {

constexpr std::size_t kPacket = 512; // of the bulk endpoints at high speed
constexpr std::size_t kMostWaiting = 256;

// Not known of the real ones: the first endpoint, the power, and the texts. An endpoint in front of
// the two in use is likely, so a host must look for them by address.
constexpr std::uint8_t kFirstEndpoint = 0x01;

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

std::vector<std::uint8_t> endpoint(std::uint8_t address) {
  return {7, 5, address, 2 /* bulk */, low(kPacket), high(kPacket), 0};
}

std::vector<std::uint8_t> text(const std::string &ascii) {
  std::vector<std::uint8_t> bytes = {low(static_cast<unsigned>(2 + 2 * ascii.size())), string};
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

Unit::Unit(int number, Board board) : number_(number), board_(std::move(board)) {}

std::uint16_t Unit::product() const noexcept {
  return board_.model() == Model::simple ? spidar::kSimpleProduct : spidar::kSh4Product;
}

std::string Unit::description() const {
  return std::string("SPIDAR-G emulator, USB2.0 ") +
         (board_.model() == Model::simple ? "Simple" : "SH4");
}

void Unit::attach(Time now) {
  attached_ = true;
  configuration_ = 0;
  halted_in_ = halted_out_ = false;
  board_.note("attached", now);
}

void Unit::detach(Time now) {
  attached_ = false;
  waiting_.clear();
  board_.note("detached", now);
}

void Unit::plug(Time now) {
  plugged_ = true;
  board_.power_on(now);
}

void Unit::stall(bool in, std::vector<Completion> &done) {
  (in ? halted_in_ : halted_out_) = true;
  if (!in)
    return;
  for (const Waiting &waiting : waiting_)
    done.push_back(failed(waiting.sequence, EPIPE));
  waiting_.clear();
}

void Unit::submit(const Transfer &transfer, Time now, std::vector<Completion> &done) {
  if (transfer.endpoint == 0) {
    done.push_back(control(transfer));
    return;
  }
  const int address = transfer.endpoint | (transfer.in ? 0x80 : 0);
  if (configuration_ == 0 || (address != spidar::kEndpointIn && address != spidar::kEndpointOut &&
                              address != kFirstEndpoint)) {
    done.push_back(failed(transfer.sequence, ENOENT));
    return;
  }
  if (address == spidar::kEndpointIn) {
    if (halted_in_) {
      done.push_back(failed(transfer.sequence, EPIPE));
    } else if (waiting_.size() >= kMostWaiting) {
      done.push_back(failed(transfer.sequence, ENOMEM));
    } else {
      waiting_.push_back({transfer.sequence, transfer.length, {}});
      collect(now, done);
    }
    return;
  }
  if (address == spidar::kEndpointOut) {
    if (halted_out_) {
      done.push_back(failed(transfer.sequence, EPIPE));
      return;
    }
    for (auto rest = transfer.data; !rest.empty();) {
      const std::size_t size = std::min(rest.size(), kPacket);
      board_.take(rest.first(size), now);
      rest = rest.subspan(size);
    }
  }
  done.push_back({transfer.sequence, 0, static_cast<std::uint32_t>(transfer.data.size()), {}});
  collect(now, done);
}

bool Unit::unlink(std::uint32_t sequence) {
  return std::erase_if(waiting_,
                       [&](const Waiting &waiting) { return waiting.sequence == sequence; }) > 0;
}

void Unit::collect(Time now, std::vector<Completion> &done) {
  for (auto ready = due(); ready && *ready <= now; ready = due()) {
    Waiting &transfer = waiting_.front();
    const std::vector<std::uint8_t> &reply = board_.reply();
    const std::size_t room = transfer.length - transfer.data.size();
    transfer.data.insert(transfer.data.end(), reply.begin(),
                         reply.begin() + static_cast<std::ptrdiff_t>(std::min(room, reply.size())));
    // As on the wire: a transfer ends when it is full or with a packet that is not.
    if (reply.size() >= room || reply.size() < kPacket) {
      const auto size = static_cast<std::uint32_t>(transfer.data.size());
      done.push_back({transfer.sequence, reply.size() > room ? -EOVERFLOW : 0, size,
                      std::move(transfer.data)});
      waiting_.pop_front();
    }
    board_.drop_reply();
  }
}

std::optional<Time> Unit::due() const {
  const auto reply = board_.next_reply();
  return waiting_.empty() || halted_in_ ? std::nullopt : reply;
}

Completion Unit::control(const Transfer &transfer) {
  std::vector<std::uint8_t> data;
  const bool from_unit = (transfer.setup[0] & kFromUnit) != 0;
  if (from_unit != transfer.in || !standard_request(transfer.setup, data))
    return failed(transfer.sequence, EPIPE);
  const std::size_t wanted = transfer.setup[6] | transfer.setup[7] << 8;
  data.resize(std::min({data.size(), wanted, static_cast<std::size_t>(transfer.length)}));
  // Nothing that the unit understands comes with data from the host.
  const auto size = static_cast<std::uint32_t>(data.size());
  return {transfer.sequence, 0, size, std::move(data)};
}

/// False for what the unit does not know.
bool Unit::standard_request(const std::array<std::uint8_t, 8> &setup,
                            std::vector<std::uint8_t> &data) {
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
  if (address == spidar::kEndpointIn)
    return &halted_in_;
  return address == spidar::kEndpointOut ? &halted_out_ : nullptr;
}

bool Unit::descriptor(int type, int index, std::vector<std::uint8_t> &data) const {
  constexpr std::uint8_t kVendorSpecific = 0xff;
  constexpr std::uint8_t kControlPacket = 64;
  if (type == device && index == 0) {
    data = {18,
            device,
            0x00,
            0x02,
            kVendorSpecific,
            0,
            0,
            kControlPacket,
            low(spidar::kVendor),
            high(spidar::kVendor),
            low(product()),
            high(product()),
            0x00,
            0x01,
            1 /* maker */,
            2 /* name */,
            0 /* no serial number */,
            1 /* configurations */};
    return true;
  }
  if (type == qualifier && index == 0) {
    data = {10, qualifier, 0x00, 0x02, kVendorSpecific, 0, 0, kControlPacket, 1, 0};
    return true;
  }
  if (type == configuration && index == 0) {
    data = {
        9, configuration, 0 /* total, below */, 0, 1 /* interfaces */, 1 /* its value */, 0, 0x80,
        50 /* 100 mA */};
    data.insert(data.end(), {9, 4, 0, 0, 3 /* endpoints */, kVendorSpecific, 0, 0, 0});
    for (const std::uint8_t address : {kFirstEndpoint, spidar::kEndpointOut, spidar::kEndpointIn}) {
      const auto bytes = endpoint(address);
      data.insert(data.end(), bytes.begin(), bytes.end());
    }
    data[2] = low(static_cast<unsigned>(data.size()));
    return true;
  }
  if (type == string && index <= 2) {
    if (index == 0)
      data = {4, string, 0x09, 0x04 /* English */};
    else
      data = text(index == 1 ? "Feeling Wind" : description());
    return true;
  }
  return false;
}

} // namespace emulator
