// SPDX-License-Identifier: LGPL-2.1-or-later
// SIGINT and SIGTERM end the work where nothing half-written stays.
#pragma once

namespace haptic {

inline constexpr int kInterrupted = 130; ///< exit status of a process

/// Lets both signals set a mark instead of ending the process. A limit of the file size (SIGXFSZ)
/// becomes an error like a full disk.
void stop_when_interrupted();

bool is_interrupted() noexcept;

/// Throws TrackFileError after one of the signals.
void throw_if_interrupted();

} // namespace haptic
