// SPDX-License-Identifier: LGPL-2.1-or-later
// Errors of haptic-track in the words of messages.hpp, and the signals that end its work where
// nothing half-written stays.
#pragma once

#include "../messages.hpp"
#include "format-text.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace haptic {

/// What is wrong with which file, for the user.
class TrackFileError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr int kInterrupted = 130; ///< exit status of a process

/// Lets SIGINT and SIGTERM set a mark instead of ending the process. A limit of the file size
/// (SIGXFSZ) becomes an error like a full disk.
void stop_when_interrupted();

bool is_interrupted() noexcept;

/// Throws TrackFileError after one of the signals.
void throw_if_interrupted();

/// Returns the text with the name of the file before it, unless it begins with a name.
std::string about(const std::string &path, const std::string &text);

/// Returns what `work` returns. An exception that it throws becomes a TrackFileError that names the
/// file, unless a signal ended the work.
template <typename Work>
auto naming(const std::string &path, const Work &work) {
  try {
    return work();
  } catch (const std::exception &error) {
    throw TrackFileError(is_interrupted() ? error.what() : about(path, error.what()));
  }
}

/// Throws a TrackFileError with the text that printf() would write.
[[noreturn, gnu::format(printf, 1, 2)]] void throw_error(const char *format, ...);

/// Throws a TrackFileError unless this is a file that can be read.
void check_readable(const std::string &path);

/// Prints an error.
void print_error(const std::string &text);

/// Prints what is remarkable in a file and ends nothing.
void print_remarks(const std::string &path, const std::vector<std::string> &remarks);

} // namespace haptic
