#include "page/web_server.h"

#include <utility>

#include <fmt/format.h>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "page/http_connection.h"
#include "twin/core/error.h"

namespace twin::page {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

}  // namespace

class WebServer::Impl {
 public:
  Impl(const WebConfig& config, ConnectionListener& listener)
      : config_(config), pool_{config_, listener}, acceptor_(context_), timer_(context_) {
    try {
      const tcp::endpoint at(asio::ip::address_v4(config.at.address), config.at.port);
      acceptor_.open(at.protocol());
      acceptor_.set_option(asio::socket_base::reuse_address(true));
      acceptor_.bind(at);
      acceptor_.listen();
    } catch (const boost::system::system_error& error) {
      throw EnvironmentError(
          fmt::format("the page cannot be served at {}: {}; is another one served there? give "
                      "another port, or 0 for a free one",
                      fci::ToString(config.at), error.code().message()));
    }
  }

  [[nodiscard]] fci::Endpoint at() const {
    return {.address = config_.at.address, .port = acceptor_.local_endpoint().port()};
  }

  void Run() {
    Tick();
    context_.run();
  }

  void Stop() { context_.stop(); }
  void Post(std::function<void()> call) { asio::post(context_, std::move(call)); }

 private:
  void Accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (!error) Admit(std::move(socket));
      // On errors such as exhausted descriptors, retry at the next tick.
      is_accepting_ = !error;
      if (!error) Accept();
    });
  }

  void Admit(tcp::socket socket) {
    error_code error;
    const auto peer = socket.remote_endpoint(error);
    if (error || !MayCome(peer.address())) return;
    socket.set_option(tcp::no_delay(true), error);
    ServeConnection(std::move(socket), pool_);
  }

  [[nodiscard]] bool MayCome(const asio::ip::address& address) const {
    if (!address.is_v4()) return false;
    const std::uint32_t from = address.to_v4().to_uint();
    return fci::IsLoopback(from) || (config_.allow && config_.allow->Contains(from));
  }

  void Tick() {
    timer_.expires_after(config_.tick);
    timer_.async_wait([this](error_code error) {
      if (error) return;
      pool_.listener.OnTick();
      Tick();
    });
    if (!std::exchange(is_accepting_, true)) Accept();
  }

  const WebConfig config_;
  ConnectionPool pool_;  ///< must outlive the work of context_
  asio::io_context context_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  bool is_accepting_ = false;
};

WebServer::WebServer(const WebConfig& config, ConnectionListener& listener)
    : impl_(std::make_unique<Impl>(config, listener)) {}

WebServer::~WebServer() = default;

fci::Endpoint WebServer::at() const noexcept {
  return impl_->at();
}

void WebServer::Run() {
  impl_->Run();
}

void WebServer::Stop() {
  impl_->Stop();
}

void WebServer::Post(std::function<void()> call) {
  impl_->Post(std::move(call));
}

}  // namespace twin::page
