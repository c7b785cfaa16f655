// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session.hpp"

#include <algorithm>
#include <cerrno>

namespace emulator {

namespace {

usbip::DeviceRecord record(const Unit &unit) {
  return {.bus_id = unit.bus_id(),
          .bus = 1,
          .device = static_cast<std::uint32_t>(unit.number()),
          .vendor = kVendorId,
          .product = unit.product(),
          .release = 0x0100,
          .device_class = 0xff,
          .interface_class = 0xff};
}

} // namespace

Session::~Session() {
  if (unit_)
    unit_->detach(Clock::now());
}

bool Session::receive(std::span<const std::uint8_t> bytes, Time now) {
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  std::size_t begin = 0;
  Progress progress = Progress::more;
  while (progress == Progress::more) {
    std::size_t used = 0;
    progress = step(std::span(input_).subspan(begin), used, now);
    begin += used;
  }
  input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(begin));
  return progress != Progress::end;
}

Session::Progress Session::request(std::span<const std::uint8_t> bytes, std::size_t &used,
                                   Time now) {
  if (bytes.size() < usbip::kRequestHeader)
    return Progress::wait;
  const auto wanted = usbip::parse_request(bytes.first<usbip::kRequestHeader>());
  if (!wanted)
    return Progress::end;
  if (*wanted == usbip::Request::list) {
    std::vector<usbip::DeviceRecord> records;
    for (const auto &unit : units_)
      if (unit->plugged())
        records.push_back(record(*unit));
    usbip::put_list(output_, records);
    return Progress::end;
  }
  used = usbip::kRequestHeader + usbip::kBusId;
  if (bytes.size() < used) {
    used = 0;
    return Progress::wait;
  }
  const auto id = bytes.subspan<usbip::kRequestHeader, usbip::kBusId>();
  return import(usbip::parse_bus_id(id), now) ? Progress::more : Progress::end;
}

bool Session::import(const std::string &bus_id, Time now) {
  const auto found = std::find_if(units_.begin(), units_.end(), [&](const auto &unit) {
    return unit->bus_id() == bus_id && unit->plugged();
  });
  if (found == units_.end()) {
    usbip::put_refused(output_, usbip::ImportStatus::no_device);
    return false;
  }
  if ((*found)->attached()) {
    usbip::put_refused(output_, usbip::ImportStatus::busy);
    return false;
  }
  unit_ = found->get();
  unit_->attach(now);
  usbip::put_imported(output_, record(*unit_));
  return true;
}

Session::Progress Session::step(std::span<const std::uint8_t> bytes, std::size_t &used, Time now) {
  if (!unit_)
    return request(bytes, used, now);
  if (bytes.size() < usbip::kCommand)
    return Progress::wait;
  const auto command = usbip::parse_command(bytes.first<usbip::kCommand>());
  if (!command)
    return Progress::end;
  if (command->kind == usbip::Command::Kind::unlink) {
    usbip::put_unlinked(output_, command->sequence,
                        unit_->unlink(command->victim) ? -ECONNRESET : 0);
    used = usbip::kCommand;
    return Progress::more;
  }
  const std::size_t following = command->in ? 0 : command->length;
  if (bytes.size() - usbip::kCommand < following)
    return Progress::wait;
  used = usbip::kCommand + following;
  unit_->submit({.sequence = command->sequence,
                 .in = command->in,
                 .endpoint = command->endpoint,
                 .length = command->length,
                 .setup = command->setup,
                 .data = bytes.subspan(usbip::kCommand, following)},
                now, done_);
  complete(done_);
  done_.clear();
  return Progress::more;
}

void Session::complete(const std::vector<Completion> &done) {
  for (const Completion &completion : done)
    usbip::put_submitted(output_, completion.sequence, completion.status, completion.actual,
                         completion.data);
}

void Session::collect(Time now) {
  if (!unit_)
    return;
  unit_->collect(now, done_);
  complete(done_);
  done_.clear();
}

std::optional<Time> Session::due() const {
  return unit_ ? unit_->due() : std::nullopt;
}

} // namespace emulator
