// SPDX-License-Identifier: LGPL-2.1-or-later
#include "word-log.hpp"

#include "fail.hpp"

#include <cerrno>
#include <filesystem>
#include <system_error>

namespace emulator {

WordLog::WordLog(const std::string &path) {
  std::error_code unknown;
  if (std::filesystem::is_fifo(path, unknown)) // opening it would wait for a reader
    spidar::fail(spidar::Cause::argument, spidar::messages::kEmulatorLog, path.c_str(),
                 "it is a FIFO");
  file_.reset(std::fopen(path.c_str(), "we"));
  if (!file_)
    spidar::fail(spidar::Cause::argument, spidar::messages::kEmulatorLog, path.c_str(),
                 std::generic_category().message(errno).c_str());
  std::fputs("time,unit,event,d0,d1,d2,d3,d4,d5,d6,d7\n", file_.get());
}

void WordLog::add(Time time, int unit, const std::string &event, const spidar::DacWords &words) {
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
  std::fprintf(file_.get(), "%lld.%06lld,%d,%s", static_cast<long long>(microseconds / 1000000),
               static_cast<long long>(microseconds % 1000000), unit, event.c_str());
  for (const std::int16_t word : words)
    std::fprintf(file_.get(), ",%d", word);
  std::fputc('\n', file_.get());
}

void WordLog::flush() {
  std::fflush(file_.get());
}

} // namespace emulator
