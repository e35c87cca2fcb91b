#pragma once

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

namespace twin::test {

/// The independent peer, tests/clients/fci_peer.py, as a process of its own on free ports; ended
/// with the object.
class PeerProcess {
 public:
  explicit PeerProcess(std::vector<std::string> options) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(ends[1], 1);
      ::close(ends[0]);
      Become(std::move(options));
    }
    ::close(ends[1]);
    std::FILE* said = ::fdopen(ends[0], "r");
    int port = 0;
    if (std::fscanf(said, "listening %d", &port) != 1) throw std::runtime_error("no peer");
    std::fclose(said);
    port_ = static_cast<std::uint16_t>(port);
  }
  ~PeerProcess() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  PeerProcess(const PeerProcess&) = delete;
  PeerProcess& operator=(const PeerProcess&) = delete;

  [[nodiscard]] std::uint16_t arm_port() const noexcept { return port_; }

 private:
  [[noreturn]] static void Become(std::vector<std::string> options) {
    std::vector<std::string> words{"python3", TWIN_SOURCE_DIR "/tests/clients/fci_peer.py",
                                   "--port", "0"};
    words.insert(words.end(), options.begin(), options.end());
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execvp("python3", arguments.data());
    ::_exit(127);
  }

  pid_t process_ = 0;
  std::uint16_t port_ = 0;
};

}  // namespace twin::test
