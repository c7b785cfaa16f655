// SPDX-License-Identifier: LGPL-2.1-or-later
#include "server.hpp"

#include "commands.hpp"
#include "fail.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <gio/gio.h>
#include <gio/gunixsocketaddress.h>
#include <glib-unix.h>
#include <list>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <unistd.h>

namespace emulator {

namespace {

// A host that reads nothing while it asks for more is disconnected.
constexpr std::size_t kMostUnsent = 1 << 22;
constexpr std::size_t kMostConnections = 64;
constexpr std::size_t kLongestLine = 1024;
constexpr int kMostReads = 16; // before others have their turn
constexpr unsigned kFlushMilliseconds = 50;

struct ObjectDeleter {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <class Object>
using Owned = std::unique_ptr<Object, ObjectDeleter>;

struct SourceDeleter {
  void operator()(GSource *source) const {
    g_source_destroy(source);
    g_source_unref(source);
  }
};
using Source = std::unique_ptr<GSource, SourceDeleter>;

struct ErrorDeleter {
  void operator()(GError *error) const { g_error_free(error); }
};
using GErrorPtr = std::unique_ptr<GError, ErrorDeleter>;

/// Returns the bytes received, or nothing if the connection has ended.
std::optional<std::span<const std::uint8_t>> receive(GSocket *socket,
                                                     std::span<std::uint8_t> buffer) {
  GError *raw = nullptr;
  const gssize size = g_socket_receive(socket, reinterpret_cast<char *>(buffer.data()),
                                       buffer.size(), nullptr, &raw);
  const GErrorPtr error(raw);
  if (size > 0)
    return buffer.first(static_cast<std::size_t>(size));
  if (error && g_error_matches(error.get(), G_IO_ERROR, G_IO_ERROR_WOULD_BLOCK))
    return buffer.first(0);
  return std::nullopt;
}

/// Sends what it can of `bytes` and removes it. False if the connection has ended.
bool send(GSocket *socket, usbip::Bytes &bytes) {
  while (!bytes.empty()) {
    GError *raw = nullptr;
    const gssize size = g_socket_send(socket, reinterpret_cast<const char *>(bytes.data()),
                                      bytes.size(), nullptr, &raw);
    const GErrorPtr error(raw);
    if (size < 0)
      return g_error_matches(error.get(), G_IO_ERROR, G_IO_ERROR_WOULD_BLOCK) != 0;
    bytes.erase(bytes.begin(), bytes.begin() + size);
  }
  return true;
}

class Server;

/// A socket that the main loop watches.
class Connection {
public:
  Connection(Server &server, GSocketConnection *connection)
      : server_(server),
        // It is GLib's macro. NOLINTNEXTLINE(modernize-type-traits)
        connection_(static_cast<GSocketConnection *>(g_object_ref(connection))),
        socket_(g_socket_connection_get_socket(connection)) {
    g_socket_set_blocking(socket_, FALSE);
    watch(readable_, G_IO_IN);
  }
  virtual ~Connection() {
    // At once, so that the host sees an unplugged device.
    g_io_stream_close(G_IO_STREAM(connection_.get()), nullptr, nullptr);
  }
  Connection(const Connection &) = delete;
  Connection &operator=(const Connection &) = delete;

  virtual Session *session() { return nullptr; }
  virtual void pump() {}

protected:
  GSocket *socket() { return socket_; }
  Server &server() { return server_; }

  /// Reads what has come. False to end the connection.
  virtual bool ready() = 0;

  /// False to end the connection.
  bool flush(usbip::Bytes &bytes) {
    if (!send(socket_, bytes) || bytes.size() > kMostUnsent)
      return false;
    if (bytes.empty())
      writable_.reset();
    else if (!writable_)
      watch(writable_, G_IO_OUT);
    return true;
  }

  /// No function of the connection is called by the main loop after this.
  void end();

private:
  void watch(Source &source, GIOCondition condition) {
    source.reset(g_socket_create_source(socket_, condition, nullptr));
    const GSocketSourceFunc happened = [](GSocket *, GIOCondition what, gpointer self) -> gboolean {
      auto *connection = static_cast<Connection *>(self);
      if ((what & G_IO_OUT) != 0)
        connection->pump();
      else if (!connection->ready())
        connection->end();
      return G_SOURCE_CONTINUE;
    };
    g_source_set_callback(source.get(), G_SOURCE_FUNC(happened), this, nullptr);
    g_source_attach(source.get(), nullptr);
  }

  Server &server_;
  Owned<GSocketConnection> connection_;
  GSocket *socket_; ///< of connection_
  Source readable_;
  Source writable_;
};

class Server {
public:
  Server(const ServerOptions &options, Units &units, WordLog *log)
      : units_(units), log_(log), loop_(g_main_loop_new(nullptr, FALSE)),
        service_(g_socket_service_new()) {
    if (!options.control.empty())
      listen_control(options.control);
    listen_tcp(options); // says that it listens, to both
  }

  ~Server() {
    g_socket_service_stop(service_.get());
    g_socket_listener_close(G_SOCKET_LISTENER(service_.get()));
    if (control_service_) {
      g_socket_service_stop(control_service_.get());
      g_socket_listener_close(G_SOCKET_LISTENER(control_service_.get()));
      unlink(control_path_.c_str());
    }
    for (const unsigned id : ids_)
      if (id != 0)
        g_source_remove(id);
  }
  Server(const Server &) = delete;
  Server &operator=(const Server &) = delete;

  void run() {
    const auto quit = [](gpointer self) -> gboolean {
      g_main_loop_quit(static_cast<Server *>(self)->loop_.get());
      return G_SOURCE_CONTINUE;
    };
    ids_.push_back(g_unix_signal_add(SIGINT, quit, this));
    ids_.push_back(g_unix_signal_add(SIGTERM, quit, this));
    const auto flush = [](gpointer self) -> gboolean {
      static_cast<Server *>(self)->log_->flush();
      return G_SOURCE_CONTINUE;
    };
    if (log_)
      ids_.push_back(g_timeout_add(kFlushMilliseconds, flush, this));
    const GUnixFDSourceFunc typed = [](int, GIOCondition, gpointer self) -> gboolean {
      auto *server = static_cast<Server *>(self);
      if (server->read_input())
        return G_SOURCE_CONTINUE;
      server->ids_.front() = 0; // GLib removes it
      return G_SOURCE_REMOVE;
    };
    ids_.insert(
        ids_.begin(),
        g_unix_fd_add(STDIN_FILENO, static_cast<GIOCondition>(G_IO_IN | G_IO_HUP), typed, this));
    g_main_loop_run(loop_.get());
    connections_.clear();
    ended_.clear();
  }

  /// Executes a command and returns the answer.
  std::string command(const std::string &line) {
    try {
      std::vector<std::vector<Completion>> done;
      obey(line, units_, Clock::now(), done);
      for (std::size_t i = 0; i < done.size(); ++i)
        for (const auto &connection : connections_)
          if (Session *session = connection->session();
              session && session->unit() == units_[i].get())
            session->complete(done[i]);
      // The connection of an unplugged unit ends.
      connections_.remove_if([](const auto &connection) {
        Session *session = connection->session();
        return session && session->unit() && !session->unit()->plugged();
      });
      pump_all();
      return "ok\n";
    } catch (const spidar::Error &error) {
      return std::string("error: ") + error.what() + "\n";
    }
  }

  /// Deletes the connection later: one of its functions may have called this, in a command of its
  /// own.
  void end(Connection *connection) {
    const auto found =
        std::ranges::find(connections_, connection, &std::unique_ptr<Connection>::get);
    if (found == connections_.end())
      return;
    ended_.splice(ended_.end(), connections_, found);
    const auto bury = [](gpointer self) -> gboolean {
      static_cast<Server *>(self)->ended_.clear();
      return G_SOURCE_REMOVE;
    };
    burial_.reset(g_idle_source_new());
    g_source_set_priority(burial_.get(), G_PRIORITY_HIGH);
    g_source_set_callback(burial_.get(), bury, this, nullptr);
    g_source_attach(burial_.get(), nullptr);
  }

  /// Calls pump_all() at `time` or before, for a late reply.
  void wake_at(Time time) {
    if (wakes_at_ && *wakes_at_ <= time)
      return;
    wakes_at_ = time;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(time - Clock::now());
    const auto wake = [](gpointer self) -> gboolean {
      static_cast<Server *>(self)->wakes_at_.reset();
      static_cast<Server *>(self)->pump_all();
      return G_SOURCE_REMOVE;
    };
    Source timer(g_timeout_source_new(static_cast<guint>(std::max<long>(0, left.count()))));
    g_source_set_callback(timer.get(), wake, this, nullptr);
    g_source_attach(timer.get(), nullptr);
    timer_ = std::move(timer);
  }

  Units &units() { return units_; }

private:
  struct LoopDeleter {
    void operator()(GMainLoop *loop) const { g_main_loop_unref(loop); }
  };

  void listen_tcp(const ServerOptions &options);
  void listen_control(const std::string &path);
  bool read_input();

  void pump_all() {
    // A connection may end meanwhile.
    for (auto next = connections_.begin(); next != connections_.end();)
      (*next++)->pump();
  }

  Units &units_;
  WordLog *log_;
  std::unique_ptr<GMainLoop, LoopDeleter> loop_;
  Owned<GSocketService> service_;
  Owned<GSocketService> control_service_;
  std::string control_path_;
  std::list<std::unique_ptr<Connection>> connections_;
  std::list<std::unique_ptr<Connection>> ended_; ///< until the main loop comes round
  Source burial_;                                ///< of ended_
  std::vector<unsigned> ids_; ///< of sources of the main loop, standard input first
  Source timer_;
  std::optional<Time> wakes_at_; ///< of timer_
  std::string input_;
};

void Connection::end() {
  readable_.reset();
  writable_.reset();
  server_.end(this);
}

/// A client of USB/IP.
class UsbConnection final : public Connection {
public:
  UsbConnection(Server &server, GSocketConnection *connection)
      : Connection(server, connection), session_(server.units()) {
    // Many small messages, each of which the host waits for.
    g_socket_set_option(socket(), IPPROTO_TCP, TCP_NODELAY, 1, nullptr);
  }

  Session *session() override { return &session_; }

  void pump() override {
    session_.collect(Clock::now());
    if (!settle())
      end();
  }

private:
  bool ready() override {
    // A host sends several requests at once: answer them together.
    for (int i = 0; i < kMostReads; ++i) {
      const auto bytes = receive(socket(), buffer_);
      if (!bytes)
        return false;
      if (bytes->empty())
        break;
      if (!session_.receive(*bytes, Clock::now())) {
        settle();
        return false;
      }
    }
    return settle();
  }

  /// Sends what is to be sent.
  bool settle() {
    if (const auto due = session_.due())
      server().wake_at(*due);
    return flush(session_.output());
  }

  Session session_;
  std::array<std::uint8_t, 16384> buffer_;
};

/// A client of the control socket.
class ControlConnection final : public Connection {
public:
  using Connection::Connection;
  void pump() override {
    if (!flush(answers_))
      end();
  }

private:
  bool ready() override {
    std::array<std::uint8_t, 512> buffer;
    const auto bytes = receive(socket(), buffer);
    if (!bytes)
      return false;
    line_.append(bytes->begin(), bytes->end());
    for (std::size_t end = line_.find('\n'); end != std::string::npos; end = line_.find('\n')) {
      const std::string answer = server().command(line_.substr(0, end));
      answers_.insert(answers_.end(), answer.begin(), answer.end());
      line_.erase(0, end + 1);
    }
    return line_.size() <= kLongestLine && flush(answers_);
  }

  std::string line_;
  usbip::Bytes answers_;
};

void Server::listen_tcp(const ServerOptions &options) {
  GError *raw = nullptr;
  const Owned<GSocketAddress> wanted(
      g_inet_socket_address_new_from_string(options.address.c_str(), options.port));
  if (!wanted)
    spidar::fail(spidar::Cause::argument, spidar::messages::kEmulatorAddress,
                 options.address.c_str());
  GSocketAddress *effective = nullptr;
  g_socket_listener_add_address(G_SOCKET_LISTENER(service_.get()), wanted.get(),
                                G_SOCKET_TYPE_STREAM, G_SOCKET_PROTOCOL_TCP, nullptr, &effective,
                                &raw);
  const GErrorPtr error(raw);
  if (error)
    spidar::fail(spidar::Cause::busy, spidar::messages::kEmulatorListen, options.address.c_str(),
                 options.port, error->message);
  const Owned<GSocketAddress> got(effective);
  const unsigned port = g_inet_socket_address_get_port(G_INET_SOCKET_ADDRESS(got.get()));
  const auto incoming =
      +[](GSocketService *, GSocketConnection *connection, GObject *, gpointer self) -> gboolean {
    auto *server = static_cast<Server *>(self);
    if (server->connections_.size() < kMostConnections)
      server->connections_.push_back(std::make_unique<UsbConnection>(*server, connection));
    return TRUE;
  };
  g_signal_connect(service_.get(), "incoming", G_CALLBACK(incoming), this);
  std::printf("listening on %s port %u\n", options.address.c_str(), port);
  for (const auto &unit : units_)
    std::printf("  %s  %s, switch %d: usbip%s attach -r %s -b %s\n", unit->bus_id().c_str(),
                unit->description().c_str(), unit->firmware().rotary_switch(),
                port == 3240 ? "" : (" --tcp-port " + std::to_string(port)).c_str(),
                options.address.c_str(), unit->bus_id().c_str());
  std::fflush(stdout);
}

void Server::listen_control(const std::string &path) {
  GError *raw = nullptr;
  const Owned<GSocketAddress> address(g_unix_socket_address_new(path.c_str()));
  control_service_.reset(g_socket_service_new());
  g_socket_listener_add_address(G_SOCKET_LISTENER(control_service_.get()), address.get(),
                                G_SOCKET_TYPE_STREAM, G_SOCKET_PROTOCOL_DEFAULT, nullptr, nullptr,
                                &raw);
  const GErrorPtr error(raw);
  if (error) {
    control_service_.reset();
    spidar::fail(spidar::Cause::busy, spidar::messages::kEmulatorControl, path.c_str(),
                 error->message);
  }
  control_path_ = path;
  const auto incoming =
      +[](GSocketService *, GSocketConnection *connection, GObject *, gpointer self) -> gboolean {
    auto *server = static_cast<Server *>(self);
    if (server->connections_.size() < kMostConnections)
      server->connections_.push_back(std::make_unique<ControlConnection>(*server, connection));
    return TRUE;
  };
  g_signal_connect(control_service_.get(), "incoming", G_CALLBACK(incoming), this);
}

/// False at the end of standard input.
bool Server::read_input() {
  std::array<char, 512> buffer;
  const ssize_t size = read(STDIN_FILENO, buffer.data(), buffer.size());
  if (size <= 0)
    return false;
  input_.append(buffer.data(), static_cast<std::size_t>(size));
  for (std::size_t end = input_.find('\n'); end != std::string::npos; end = input_.find('\n')) {
    std::fputs(command(input_.substr(0, end)).c_str(), stdout);
    std::fflush(stdout);
    input_.erase(0, end + 1);
  }
  return input_.size() <= kLongestLine;
}

} // namespace

void serve(const ServerOptions &options, Units &units, WordLog *log) {
  Server server(options, units, log);
  server.run();
  if (log)
    log->flush();
}

} // namespace emulator
