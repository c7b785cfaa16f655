// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author.hpp"

#include "track-file.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <poll.h>
#include <sstream>
#include <string_view>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace haptic {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLineEvery = std::chrono::seconds(10); // where there is no terminal
constexpr auto kBarEvery = std::chrono::milliseconds(200);
constexpr int kBarWidth = 24; // characters
constexpr int kInterrupted = 130;

volatile std::sig_atomic_t interrupted = 0;

std::string single_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

// ---- the process of one video -------------------------------------------------------------------

// Authors one video and writes lines to `out`: "P done frames" (progress) again and again, "R
// remark", and at the end "D frames path" (done), "S frames path" (it was there) or "E error".
int work_on(const std::string &path, const AuthorOptions &options, int out) {
  const auto send_line = [&](const std::string &line) {
    const std::string whole = single_line(line) + "\n";
    // Nobody reads the lines any more.
    if (write(out, whole.data(), whole.size()) < 0)
      _exit(EXIT_FAILURE);
  };
  try {
    const Authored made = author_file(path, options, [&](const AuthorProgress &progress) {
      send_line("P " + std::to_string(progress.done) + " " + std::to_string(progress.frames));
    });
    for (const auto &remark : made.remarks)
      send_line("R " + remark);
    send_line((made.existed ? "S " : "D ") + std::to_string(made.frames) + " " + made.path);
    return EXIT_SUCCESS;
  } catch (const std::exception &error) {
    send_line(std::string("E ") + error.what());
    return EXIT_FAILURE;
  }
}

struct Job {
  std::string path;
  double weight = 1; // bytes of the video
  pid_t pid = 0;
  int in = -1;
  std::string unread; // a line that has not wholly come
  double done = 0;
  std::uint64_t frames = 0;
  std::string result; // the last line
  Clock::time_point begun;
};

Job start(const std::string &path, const AuthorOptions &options) {
  int ends[2];
  if (pipe(ends) != 0)
    throw_error(messages::kProcessFails, std::strerror(errno));
  std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0)
    throw_error(messages::kProcessFails, std::strerror(errno));
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL); // nobody works on for a dead one
    if (getppid() != parent)
      _exit(EXIT_FAILURE);
    signal(SIGINT, SIG_IGN); // the parent decides
    signal(SIGTERM, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); // a limit of the file size is an error like a full disk
    close(ends[0]);
    const int status = work_on(path, options, ends[1]);
    std::fflush(nullptr);
    _exit(status);
  }
  close(ends[1]);
  Job job;
  job.path = path;
  job.pid = pid;
  job.in = ends[0];
  job.begun = Clock::now();
  return job;
}

// ---- what the user sees -------------------------------------------------------------------------

std::string duration_text(double seconds) {
  char text[32];
  const auto whole = static_cast<long>(seconds);
  if (whole < 60)
    std::snprintf(text, sizeof text, "%ld s", whole);
  else if (whole < 3600)
    std::snprintf(text, sizeof text, "%ld min %02ld s", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
  return text;
}

double since(Clock::time_point time) {
  return std::max(1e-3, std::chrono::duration<double>(Clock::now() - time).count());
}

double size_of(const std::string &path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 1 : std::max(1.0, static_cast<double>(size));
}

class Authoring {
public:
  Authoring(const std::vector<std::string> &files, const AuthorOptions &options)
      : files_(files), options_(options) {
    for (const auto &file : files)
      all_weight_ += size_of(file);
  }

  int run(unsigned most_jobs) {
    for (;;) {
      while (interrupted == 0 && jobs_.size() < most_jobs && next_ < files_.size())
        begin_next();
      if (jobs_.empty())
        break;
      if (interrupted != 0) {
        stop_all();
        break;
      }
      listen();
      show_progress();
    }
    erase_bar();
    return summary();
  }

private:
  void begin_next() {
    const std::string &path = files_[next_++];
    // A second video of the same name would be taken for done when the first one is.
    const auto [other, is_new] = stems_.emplace(author_stem(path, options_), path);
    if (!is_new && other->second != path) {
      report_failure(formatted(messages::kCopyNamesCollide, path.c_str(), other->second.c_str()));
      done_weight_ += size_of(path);
      return;
    }
    jobs_.push_back(start(path, options_));
    jobs_.back().weight = size_of(path);
  }

  void listen() {
    std::vector<pollfd> waiting;
    for (const Job &job : jobs_)
      waiting.push_back({job.in, POLLIN, 0});
    if (poll(waiting.data(), waiting.size(), 200) <= 0)
      return;
    for (std::size_t i = waiting.size(); i-- > 0;)
      if (waiting[i].revents != 0 && !read_lines(jobs_[i])) {
        finish(jobs_[i]);
        jobs_.erase(jobs_.begin() + static_cast<std::ptrdiff_t>(i));
      }
  }

  // Returns false at the end of the lines.
  bool read_lines(Job &job) {
    char bytes[4096];
    const ssize_t count = read(job.in, bytes, sizeof bytes);
    if (count <= 0)
      return count < 0 && errno == EINTR;
    job.unread.append(bytes, static_cast<std::size_t>(count));
    for (auto end = job.unread.find('\n'); end != std::string::npos; end = job.unread.find('\n')) {
      read_line(job, job.unread.substr(0, end));
      job.unread.erase(0, end + 1);
    }
    return true;
  }

  void read_line(Job &job, const std::string &line) {
    if (line.starts_with("P ")) {
      std::istringstream(line.substr(2)) >> job.done >> job.frames;
    } else if (line.starts_with("R ")) {
      print_line(stderr, "\"" + job.path + "\": " + line.substr(2));
    } else {
      job.result = line;
    }
  }

  void finish(Job &job) {
    close(job.in);
    int status = 0;
    waitpid(job.pid, &status, 0);
    done_weight_ += job.weight;
    const bool has_path = job.result.starts_with("D ") || job.result.starts_with("S ");
    if (has_path && WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      std::istringstream words(job.result.substr(2));
      std::uint64_t frames = 0;
      std::string copy;
      std::getline(words >> frames >> std::ws, copy);
      if (job.result[0] == 'S') {
        ++existed_;
        print_line(stdout, "there already: " + copy);
        return;
      }
      ++written_;
      frames_ += frames;
      char speed[64];
      std::snprintf(speed, sizeof speed, " (%llu frames, %.0f a second)",
                    static_cast<unsigned long long>(frames),
                    static_cast<double>(frames) / since(job.begun));
      print_line(stdout, "written: " + copy + speed);
      return;
    }
    remove_part(job);
    if (job.result.starts_with("E "))
      report_failure(job.result.substr(2));
    else
      report_failure(
          formatted(messages::kProcessCrashed, job.path.c_str(), how_it_ended(status).c_str()));
  }

  void remove_part(const Job &job) const {
    std::error_code error;
    std::filesystem::remove(author_part(job.path, options_), error);
  }

  void stop_all() {
    for (Job &job : jobs_) {
      kill(job.pid, SIGKILL);
      waitpid(job.pid, nullptr, 0);
      close(job.in);
      remove_part(job);
    }
    jobs_.clear();
  }

  static std::string how_it_ended(int status) {
    if (!WIFSIGNALED(status))
      return "ended without a result";
    return std::string("was ended by the signal ") + strsignal(WTERMSIG(status));
  }

  void report_failure(const std::string &why) {
    ++failed_;
    print_line(stderr, "haptic-track: " + why);
  }

  void print_line(std::FILE *where, const std::string &line) {
    erase_bar();
    std::fprintf(where, "%s\n", line.c_str());
    std::fflush(where);
  }

  void erase_bar() {
    if (std::exchange(bar_shown_, false))
      std::fputs("\r\033[K", stderr);
  }

  void show_progress() {
    const auto every = terminal_ ? Clock::duration(kBarEvery) : Clock::duration(kLineEvery);
    if (Clock::now() - shown_ < every)
      return;
    shown_ = Clock::now();
    double done = done_weight_;
    std::uint64_t frames = frames_;
    for (const Job &job : jobs_) {
      done += job.weight * job.done;
      frames += job.frames;
    }
    done = std::min(done / all_weight_, 1.0);
    const double seconds = since(begun_);
    char text[160];
    std::snprintf(text, sizeof text, "%3.0f %%  %zu of %zu files, %llu frames, %.0f a second",
                  100 * done, written_ + existed_ + failed_, files_.size(),
                  static_cast<unsigned long long>(frames), static_cast<double>(frames) / seconds);
    std::string line = text;
    if (done > 0.005 && seconds > 1)
      line += ", " + duration_text(seconds * (1 - done) / done) + " left";
    if (!terminal_) {
      std::fprintf(stderr, "%s\n", line.c_str());
      return;
    }
    const int full = static_cast<int>(kBarWidth * done);
    std::fprintf(
        stderr, "\r\033[K[%s%s] %s", std::string(static_cast<std::size_t>(full), '#').c_str(),
        std::string(static_cast<std::size_t>(kBarWidth - full), '.').c_str(), line.c_str());
    std::fflush(stderr);
    bar_shown_ = true;
  }

  int summary() const {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const double seconds = since(begun_);
    std::printf("%zu written, %zu there already, %zu failed", written_, existed_, failed_);
    if (interrupted != 0)
      std::printf(", %zu not done: run it again to go on",
                  files_.size() - written_ - existed_ - failed_);
    std::printf("; %llu frames in %s, %.0f a second, at most %ld MB a process\n",
                static_cast<unsigned long long>(frames_), duration_text(seconds).c_str(),
                static_cast<double>(frames_) / seconds, usage.ru_maxrss / 1024);
    return interrupted != 0 ? kInterrupted : failed_ > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
  }

  const std::vector<std::string> &files_;
  const AuthorOptions &options_;
  std::size_t next_ = 0;
  std::vector<Job> jobs_;
  std::map<std::string, std::string> stems_; // of copies, and their videos
  double all_weight_ = 0;
  double done_weight_ = 0;
  std::size_t written_ = 0;
  std::size_t existed_ = 0;
  std::size_t failed_ = 0;
  std::uint64_t frames_ = 0;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool bar_shown_ = false;
  const Clock::time_point begun_ = Clock::now();
  Clock::time_point shown_ = Clock::now();
};

} // namespace

int author(const std::vector<std::string> &files, const AuthorOptions &options, unsigned jobs) {
  if (!options.folder.empty() && !std::filesystem::is_directory(options.folder))
    throw_error(messages::kFolderIsMissing, options.folder.c_str());
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return Authoring(files, options).run(jobs);
}

} // namespace haptic
