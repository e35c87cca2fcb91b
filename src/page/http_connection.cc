#include "page/http_connection.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/bind_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "page/origin_check.h"
#include "page/site.h"
#include "twin/core/secret.h"

namespace twin::page {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

constexpr std::uint32_t kLongestHeader = 8192;

/// Permits only our own files and sockets, and forbids embedding in foreign frames.
constexpr std::string_view kSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

std::string_view ViewOf(beast::string_view text) {
  return {text.data(), text.size()};
}

fci::Endpoint LocalOf(const beast::tcp_stream& stream) {
  error_code error;
  const auto local = stream.socket().local_endpoint(error);
  if (error || !local.address().is_v4()) return {};
  return {.address = local.address().to_v4().to_uint(), .port = local.port()};
}

Response PlainResponse(http::status status, std::string_view text) {
  Response response{status, 11};
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = text;
  return response;
}

Response FileResponse(const SiteFile& file) {
  Response response{http::status::ok, 11};
  response.set(http::field::content_type, fmt::format("{}; charset=utf-8", file.type));
  response.body() = file.text;
  return response;
}

/// Whether the request has the token, once.
bool HasToken(const Request& request, std::string_view token) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view given = ViewOf(request[http::field::authorization]);
  return request.count(http::field::authorization) == 1 && given.starts_with(kScheme) &&
         IsSameSecret(given.substr(kScheme.size()), token);
}

Response PrivateResponse(const Request& request, const PrivateFile& file) {
  if (!HasToken(request, file.token)) {
    Response response =
        PlainResponse(http::status::unauthorized, "The token is missing or wrong\n");
    response.set(http::field::www_authenticate, "Bearer");
    return response;
  }
  Response response{http::status::ok, 11};
  response.set(http::field::content_type, "application/octet-stream");
  response.set(http::field::cache_control, "private, max-age=31536000, immutable");
  response.body() = *file.bytes;
  return response;
}

/// The response to an HTTP request.
Response Answer(const Request& request, const std::optional<PrivateFile>& private_file) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Response response = PlainResponse(http::status::method_not_allowed, "GET and HEAD only\n");
    response.set(http::field::allow, "GET, HEAD");
    return response;
  }
  if (private_file && ViewOf(request.target()) == private_file->path) {
    return PrivateResponse(request, *private_file);
  }
  const auto files = Site();
  const auto file = std::ranges::find(files, ViewOf(request.target()), &SiteFile::path);
  if (file == files.end()) return PlainResponse(http::status::not_found, "There is no such file\n");
  return FileResponse(*file);
}

/// A browser's WebSocket. It owns itself during asynchronous operations (Asio's idiom), hence the
/// shared_ptr.
class Socket final : public Connection,
                     public Droppable,
                     public std::enable_shared_from_this<Socket> {
 public:
  Socket(beast::tcp_stream stream, ConnectionPool& pool, std::unique_ptr<PoolEntry> entry)
      : stream_(std::move(stream)),
        pool_(pool),
        entry_(std::move(entry)),
        deadline_(stream_.get_executor()) {
    entry_->PassTo(*this);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void Start(const Request& request) {
    stream_.set_option(websocket::stream_base::timeout{.handshake_timeout = pool_.config.timeout,
                                                       .idle_timeout = 4 * pool_.config.timeout,
                                                       .keep_alive_pings = true});
    stream_.read_message_max(pool_.config.longest_message);
    stream_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->pool_.listener.OnConnect(*self);
      self->Read();
    });
  }

  void Send(SharedFrame frame) override {
    if (is_closing_) return;
    if (queue_.size() >= pool_.config.most_waiting) {
      Drop();
      return;
    }
    queue_.push_back(std::move(frame));
    if (queue_.size() == 1) Write();
  }

  [[nodiscard]] std::size_t waiting() const noexcept override { return queue_.size(); }
  void Authenticate() override { entry_->Authenticate(); }

  void Close(std::string_view reason) override {
    if (is_closing_) return;
    is_closing_ = true;
    reason_ = reason.substr(0, 120);  // limit of a close frame
    if (queue_.empty()) SendClose();
  }

 private:
  void Read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) {
        self->Leave();
        return;
      }
      self->Take();
      self->Read();
    });
  }

  void Take() {
    if (!is_closing_) {
      if (stream_.got_text()) {
        const auto bytes = buffer_.data();
        pool_.listener.OnText(*this, {static_cast<const char*>(bytes.data()), bytes.size()});
      } else {
        Close("only text is understood");
      }
    }
    buffer_.clear();
  }

  void Write() {
    stream_.text(queue_.front()->is_text);
    deadline_.expires_after(pool_.config.timeout);
    deadline_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->Drop();
    });
    stream_.async_write(asio::buffer(queue_.front()->bytes),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          self->deadline_.cancel();
                          if (!error) self->Written();
                        });
  }

  void Written() {
    queue_.pop_front();
    if (!queue_.empty()) {
      Write();
    } else if (is_closing_) {
      SendClose();
    }
  }

  void SendClose() {
    stream_.async_close({websocket::close_code::policy_error, reason_},
                        [self = shared_from_this()](error_code /*error*/) {});
  }

  /// Does not wait; pending operations end with an error.
  void Drop() override {
    is_closing_ = true;
    entry_->Leave();
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

  void Leave() {
    is_closing_ = true;
    deadline_.cancel();
    pool_.listener.OnDisconnect(*this);
    Drop();
  }

  websocket::stream<beast::tcp_stream> stream_;
  ConnectionPool& pool_;
  const std::unique_ptr<PoolEntry> entry_;
  asio::steady_timer deadline_;
  beast::flat_buffer buffer_;
  std::deque<SharedFrame> queue_;  ///< the first is being sent
  bool is_closing_ = false;
  std::string reason_;
};

/// A browser's HTTP connection; becomes a Socket on a WebSocket upgrade. Owns itself as Socket
/// does.
class Files final : public Droppable, public std::enable_shared_from_this<Files> {
 public:
  Files(asio::ip::tcp::socket socket, ConnectionPool& pool)
      : stream_(std::move(socket)),
        pool_(pool),
        local_(LocalOf(stream_)),
        entry_(std::make_unique<PoolEntry>(pool, *this)) {}
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  void Read() {
    parser_.emplace();
    parser_->header_limit(kLongestHeader);
    parser_->body_limit(0);
    stream_.expires_after(pool_.config.timeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](error_code error, std::size_t) {
                       if (!error) self->Decide();
                     });
  }

  void Drop() override {
    entry_->Leave();
    error_code ignored;
    stream_.socket().close(ignored);
  }

 private:
  void Decide() {
    const Request& request = parser_->get();
    const std::string_view host = ViewOf(request[http::field::host]);
    if (pool_.authenticated >= pool_.config.most_connections) {
      Reply(PlainResponse(http::status::service_unavailable, "Too many look on already\n"));
    } else if (request.count(http::field::host) != 1) {
      // With several headers, an intermediary may have checked another one than we do.
      Reply(PlainResponse(http::status::bad_request, "One header Host, no more and no less\n"));
    } else if (!IsOurHost(host, local_)) {
      Reply(PlainResponse(http::status::misdirected_request,
                          "This page is asked for by its address, as panda-twin prints it\n"));
    } else if (!websocket::is_upgrade(request) || request.target() != "/ws") {
      Reply(Answer(request, pool_.config.private_file));
    } else if (!IsOurOrigin(ViewOf(request[http::field::origin]), host)) {
      Reply(PlainResponse(http::status::forbidden, "Only our own page may open this WebSocket\n"));
    } else {
      stream_.expires_never();  // the WebSocket has its own timeouts
      std::make_shared<Socket>(std::move(stream_), pool_, std::move(entry_))->Start(request);
    }
  }

  void Reply(Response response) {
    const Request& request = parser_->get();
    if (response.count(http::field::cache_control) == 0) {
      response.set(http::field::cache_control, "no-store");
    }
    response.set("X-Content-Type-Options", "nosniff");
    response.set("X-Frame-Options", "DENY");
    response.set("Content-Security-Policy",
                 beast::string_view(kSecurityPolicy.data(), kSecurityPolicy.size()));
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.keep_alive(request.keep_alive() && response.result() == http::status::ok);
    response.prepare_payload();
    if (request.method() == http::verb::head) response.body().clear();
    response_ = std::move(response);
    stream_.expires_after(pool_.config.transfer_timeout);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (!error && self->response_.keep_alive()) self->Read();
                      });
  }

  beast::tcp_stream stream_;
  ConnectionPool& pool_;
  const fci::Endpoint local_;
  std::unique_ptr<PoolEntry> entry_;  ///< null once passed to a Socket
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  Response response_;
};

}  // namespace

void ServeConnection(asio::ip::tcp::socket socket, ConnectionPool& pool) {
  if (pool.unauthenticated.size() >= pool.config.most_connections)
    pool.unauthenticated.front()->Drop();
  std::make_shared<Files>(std::move(socket), pool)->Read();
}

}  // namespace twin::page
