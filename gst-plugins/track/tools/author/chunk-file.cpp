// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/chunk-file.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>
#include <sys/mman.h>

namespace haptic {
namespace {

// The last line: this, the mark, frames, confidence and the SHA-256 of what stands before it.
constexpr std::string_view kLastLine = "\nfeeling-wind-chunk ";
constexpr std::size_t kLongestLine = 256;
constexpr std::size_t kHashedAtOnce = 1 << 20; // bytes

} // namespace

// ---- writing ------------------------------------------------------------------------------------

ChunkWriter::ChunkWriter(std::string path, std::string mark)
    : path_(std::move(path)), mark_(std::move(mark)), part_(path_ + ".part") {}

void ChunkWriter::add(const CodedField &field) {
  const std::vector<std::uint8_t> set = write_klv(field);
  hash_.add(set.data(), set.size());
  part_.write(set);
}

void ChunkWriter::finish(const ChunkStats &stats) {
  std::ostringstream line;
  line << kLastLine << mark_ << ' ' << stats.frames << ' ' << stats.confidence << ' '
       << hash_.digits() << '\n';
  const std::string text = line.str();
  part_.write({reinterpret_cast<const std::uint8_t *>(text.data()), text.size()});
  part_.keep_as(path_);
}

// ---- reading ------------------------------------------------------------------------------------

ChunkReader::ChunkReader(const std::string &path, const std::string &mark) {
  file_.reset(g_mapped_file_new(path.c_str(), FALSE, nullptr));
  if (!file_)
    return;
  problem_ = messages::kChunkIsDamaged;
  const std::string_view all(g_mapped_file_get_contents(file_.get()),
                             g_mapped_file_get_length(file_.get()));
  const std::size_t from = all.size() > kLongestLine ? all.size() - kLongestLine : 0;
  const std::size_t at = all.substr(from).rfind(kLastLine);
  if (at == all.npos)
    return;
  size_ = from + at;
  std::istringstream line{std::string(all.substr(size_ + kLastLine.size()))};
  std::string held_mark;
  std::string held_sum;
  if (!(line >> held_mark >> stats_.frames >> stats_.confidence >> held_sum))
    return;
  ContentHash hash;
  for (std::size_t done = 0; done < size_; done += kHashedAtOnce) {
    hash.add(all.data() + done, std::min(kHashedAtOnce, size_ - done));
    forget();
  }
  if (held_sum == hash.digits())
    problem_ = held_mark == mark ? nullptr : messages::kChunkIsForeign;
}

std::span<const std::uint8_t> ChunkReader::fields() const noexcept {
  return {reinterpret_cast<const std::uint8_t *>(g_mapped_file_get_contents(file_.get())), size_};
}

// posix_madvise() would do nothing in glibc.
void ChunkReader::forget() const noexcept {
  madvise(g_mapped_file_get_contents(file_.get()), g_mapped_file_get_length(file_.get()),
          MADV_DONTNEED);
}

} // namespace haptic
