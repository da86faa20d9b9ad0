// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/web_server.h"

#include <chrono>
#include <deque>
#include <list>
#include <map>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace hrp {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Request = http::request<http::string_body>;
using ErrorCode = boost::system::error_code;

// What clients send is short; the largest question is a list of signals.
constexpr size_t kLargestMessage = 64 * 1024;
constexpr size_t kLargestHeader = 16 * 1024;
constexpr size_t kLargestBody = 1024;
// Pictures wait behind few others: a page that is slow shows the newest soon, not a film of the past.
constexpr size_t kDroppableDepth = 8;
constexpr size_t kDroppableBytes = 4 << 20;
// One picture of a camera under way is enough: the next one is newer.
constexpr size_t kPictureBytes = 1 << 20;
constexpr size_t kStreamDepth = 8192;
constexpr size_t kStreamBytes = 32 << 20;
// Answers are as large as series of charts; 64 of them unread is nobody reading.
constexpr size_t kNeededDepth = 64;
constexpr size_t kNeededBytes = 256 << 20;
constexpr size_t kMostConnections = 64;
// Of one address, when others than this machine may connect. A browser opens six, and one for each page.
constexpr size_t kMostOfOneAddress = 24;
// Who has connected asks within this time, and reads the answer within the other one.
constexpr auto kQuestionTime = std::chrono::seconds(10);
constexpr auto kAnswerTime = std::chrono::seconds(30);
// A page that is there answers pings; what does not is gone.
constexpr auto kSilence = std::chrono::seconds(60);

class HttpSession;

struct Shared {
  WebOptions options;
  WebApplication& application;
  size_t connections = 0;
  std::map<std::string, size_t> of_address;
  std::list<HttpSession*> idle;  // connected, and have not asked anything yet; the first one for the longest time
};

// Counts a connection for as long as it is there.
class Counted {
 public:
  Counted(std::shared_ptr<Shared> shared, std::string address)
      : shared_(std::move(shared)), address_(std::move(address)) {
    ++shared_->connections;
    ++shared_->of_address[address_];
  }
  ~Counted() {
    --shared_->connections;
    if (--shared_->of_address[address_] == 0) shared_->of_address.erase(address_);
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  Shared* operator->() const { return shared_.get(); }
  const std::shared_ptr<Shared>& shared() const { return shared_; }
  const std::string& address() const { return address_; }

 private:
  std::shared_ptr<Shared> shared_;
  std::string address_;
};

std::string to_text(beast::string_view view) { return std::string(view.data(), view.size()); }

// The protocol of Foxglove that a client offers and we speak; empty when there is none.
std::string find_foxglove_protocol(const Request& request) {
  const std::string offered = to_text(request[http::field::sec_websocket_protocol]);
  for (const char* protocol : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    if (offered.find(protocol) != std::string::npos) return protocol;
  }
  return "";
}

class SocketSession final : public Connection, public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(beast::tcp_stream&& stream, const Counted& http)
      : socket_(std::move(stream)), shared_(http.shared(), http.address()) {}

  void start(const Request& request, const std::string& protocol) {
    foxglove_ = !protocol.empty();
    auto times = websocket::stream_base::timeout::suggested(beast::role_type::server);
    times.idle_timeout = kSilence;
    socket_.set_option(times);
    socket_.set_option(websocket::stream_base::decorator([protocol](websocket::response_type& response) {
      if (!protocol.empty()) response.set(http::field::sec_websocket_protocol, protocol);
    }));
    socket_.read_message_max(kLargestMessage);
    socket_.async_accept(request, [self = shared_from_this()](ErrorCode error) {
      if (!error) self->open();
    });
  }

  bool send(Payload payload, bool binary, Urgency urgency) override {
    if (closing_) return false;
    if (is_full(urgency)) {
      if (urgency == Urgency::kNeeded) abort();
      return false;
    }
    queued_needed_ += urgency == Urgency::kNeeded ? 1 : 0;
    queued_bytes_ += payload->size();
    queue_.push_back({std::move(payload), binary, urgency == Urgency::kNeeded});
    if (queue_.size() == 1) write();
    return true;
  }

 private:
  struct Outgoing {
    Payload payload;
    bool binary;
    bool needed;
  };

  bool is_full(Urgency urgency) const {
    if (urgency == Urgency::kNeeded) return queued_needed_ >= kNeededDepth || queued_bytes_ >= kNeededBytes;
    if (urgency == Urgency::kPicture) return queued_bytes_ >= kPictureBytes;
    const bool stream = urgency == Urgency::kStream;
    return queue_.size() >= (stream ? kStreamDepth : kDroppableDepth) ||
           queued_bytes_ >= (stream ? kStreamBytes : kDroppableBytes);
  }

  void open() {
    auto& application = shared_->application;
    client_ = foxglove_ ? application.make_foxglove_client(*this) : application.make_page_client(*this);
    read();
  }

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](ErrorCode error, size_t) {
      // Closed, cut off, too large, malformed: in any case the end of this connection alone.
      if (error) return self->end();
      self->take();
    });
  }

  void take() {
    // A read that was finished before this connection ended comes after its client is gone.
    if (closing_ || !client_) return;
    const std::string message = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    try {
      client_->on_message(message, socket_.got_binary());
    } catch (const ProtocolError& error) {
      return close(error.what());
    }
    if (!closing_) read();
  }

  void write() {
    socket_.binary(queue_.front().binary);
    socket_.async_write(asio::buffer(*queue_.front().payload), [self = shared_from_this()](ErrorCode error, size_t) {
      if (error) return self->end();
      self->queued_bytes_ -= self->queue_.front().payload->size();
      self->queued_needed_ -= self->queue_.front().needed ? 1 : 0;
      self->queue_.pop_front();
      if (!self->queue_.empty() && !self->closing_) self->write();
    });
  }

  void close(const std::string& reason) {
    if (closing_) return;
    closing_ = true;
    client_.reset();
    // A close frame holds at most 123 bytes of reason.
    const websocket::close_reason why(websocket::close_code::policy_error, reason.substr(0, 120));
    socket_.async_close(why, [self = shared_from_this()](ErrorCode) {});
  }

  void abort() {
    closing_ = true;
    beast::get_lowest_layer(socket_).cancel();
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->end(); });
  }

  void end() {
    closing_ = true;
    client_.reset();
    beast::get_lowest_layer(socket_).close();
  }

  websocket::stream<beast::tcp_stream> socket_;
  Counted shared_;
  std::unique_ptr<Client> client_;
  beast::flat_buffer buffer_;
  std::deque<Outgoing> queue_;  // the first one is being written
  size_t queued_bytes_ = 0;
  size_t queued_needed_ = 0;
  bool foxglove_ = false;
  bool closing_ = false;
};

class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(tcp::socket&& socket, std::shared_ptr<Shared> shared, const std::string& address)
      : stream_(std::move(socket)), shared_(std::move(shared), address) {}
  ~HttpSession() { shared_->idle.remove(this); }

  void read() {
    parser_.emplace();
    parser_->header_limit(kLargestHeader);
    parser_->body_limit(kLargestBody);
    stream_.expires_after(kQuestionTime);
    shared_->idle.push_back(this);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](ErrorCode error, size_t) {
      self->shared_->idle.remove(self.get());
      if (!error) self->answer(self->parser_->release());
    });
  }

  const std::string& address() const { return shared_.address(); }
  // Makes room for others.
  void give_up() {
    shared_->idle.remove(this);
    stream_.close();
  }

 private:
  void answer(const Request& request) {
    const std::string protocol = find_foxglove_protocol(request);
    AccessRequest access;
    access.target = to_text(request.target());
    access.host = to_text(request[http::field::host]);
    access.origin = to_text(request[http::field::origin]);
    access.cookie = to_text(request[http::field::cookie]);
    access.foxglove = !protocol.empty();
    const std::string refusal = find_refusal(shared_->options.access, access);
    if (!refusal.empty()) return reply(request, http::status::forbidden, {refusal + "\n", "text/plain"});
    if (websocket::is_upgrade(request)) {
      stream_.expires_never();
      return std::make_shared<SocketSession>(std::move(stream_), shared_)->start(request, protocol);
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      return reply(request, http::status::method_not_allowed, {"only GET\n", "text/plain"});
    }
    std::optional<WebFile> file = shared_->application.find_file(access.target);
    if (!file) return reply(request, http::status::not_found, {"there is no such file\n", "text/plain"});
    reply(request, http::status::ok, std::move(*file));
  }

  void reply(const Request& request, http::status status, WebFile file) {
    auto response = std::make_shared<http::response<http::string_body>>(status, request.version());
    response->set(http::field::content_type, file.type);
    response->set(http::field::cache_control, "no-cache");
    response->set("X-Content-Type-Options", "nosniff");
    // Nothing is fetched from elsewhere, and the browser makes sure of it.
    response->set("Content-Security-Policy",
                  "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                  "connect-src 'self' ws: wss:; frame-ancestors 'none'");
    const std::string& token = shared_->options.access.token;
    if (!token.empty() && status == http::status::ok) {
      response->set(http::field::set_cookie,
                    make_cookie_name(shared_->options.access) + "=" + token + "; HttpOnly; SameSite=Strict; Path=/");
    }
    response->keep_alive(request.keep_alive());
    response->body() = std::move(file.content);
    response->prepare_payload();
    if (request.method() == http::verb::head) response->body().clear();
    stream_.expires_after(kAnswerTime);
    http::async_write(stream_, *response, [self = shared_from_this(), response](ErrorCode error, size_t) {
      if (!error && response->keep_alive()) return self->read();
      ErrorCode ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  beast::tcp_stream stream_;
  Counted shared_;
  beast::flat_buffer buffer_;
  boost::optional<http::request_parser<http::string_body>> parser_;
};

}  // namespace

struct WebServer::State {
  State(const WebOptions& options, WebApplication& application)
      : shared(std::make_shared<Shared>(Shared{options, application, 0, {}, {}})), acceptor(context), timer(context) {}

  void accept() {
    acceptor.async_accept(context, [this](ErrorCode error, tcp::socket socket) {
      ErrorCode gone;
      const std::string address = error ? "" : socket.remote_endpoint(gone).address().to_string();
      if (!error && !gone && make_room(address)) {
        ErrorCode ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        std::make_shared<HttpSession>(std::move(socket), shared, address)->read();
      }
      accept();
    });
  }

  // Whoever connects and asks nothing goes first: idle connections, however many, keep nobody out. On this machine all
  // clients have one address, so it tells nothing there.
  bool make_room(const std::string& address) {
    const auto same = shared->of_address.find(address);
    const bool crowded =
        !shared->options.access.loopback && same != shared->of_address.end() && same->second >= kMostOfOneAddress;
    if (!crowded && shared->connections < kMostConnections) return true;
    for (HttpSession* session : shared->idle) {
      if (crowded && session->address() != address) continue;
      session->give_up();
      return true;
    }
    return false;
  }

  void wait(int period_ms, const std::function<bool()>& tick) {
    timer.expires_after(std::chrono::milliseconds(period_ms));
    timer.async_wait([this, period_ms, &tick](ErrorCode) {
      if (tick()) return wait(period_ms, tick);
      context.stop();
    });
  }

  asio::io_context context{1};
  std::shared_ptr<Shared> shared;
  tcp::acceptor acceptor;
  asio::steady_timer timer;
};

WebServer::WebServer(const WebOptions& options, WebApplication& application)
    : state_(std::make_unique<State>(options, application)) {
  try {
    const tcp::endpoint endpoint(asio::ip::make_address(options.address), options.port);
    state_->acceptor.open(endpoint.protocol());
    state_->acceptor.set_option(asio::socket_base::reuse_address(true));
    state_->acceptor.bind(endpoint);
    state_->acceptor.listen();
    state_->shared->options.access.port = port();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("cannot serve at " + options.address + ":" + std::to_string(options.port) + ": " +
                             error.code().message());
  }
}

WebServer::~WebServer() = default;

uint16_t WebServer::port() const { return state_->acceptor.local_endpoint().port(); }

void WebServer::run(int period_ms, const std::function<bool()>& tick) {
  state_->accept();
  state_->wait(period_ms, tick);
  state_->context.run();
}

}  // namespace hrp
