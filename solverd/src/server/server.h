// The daemon's loop: one ROUTER socket, one worker thread per client. The loop never solves and never waits for a
// worker, so pings and cancels are answered at once.
#pragma once
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "platform/platform.h"
#include "server/decode.h"
#include "server/message.h"
#include "server/solver_port.h"
#include "server/worker.h"

namespace lappet {

struct ServerOptions {
  std::string address = "tcp://127.0.0.1:*";  // loopback, or a socket in a private folder
  std::string token;                          // what `hello` must bring; not empty
  std::uint64_t max_message_bytes = kDefaultMaxMessageBytes;
  std::size_t max_clients = 8;
  std::uint64_t first_session = 1;            // the number of the first session
  std::chrono::milliseconds silence{60'000};  // a client, and the daemon, ends after hearing nothing for so long
  std::chrono::milliseconds silence_where_full{15'000};  // a client, when another wants its place: three pings
  int input = -1;                                        // a file descriptor whose end of file ends the daemon, or -1
  int parent = 0;                                        // a process whose end ends the daemon, or 0
};

class Server {
 public:
  // Binds. Throws RefusedError where the options make no sense or the address is taken.
  Server(ServerOptions options, SolverFactory factory);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // The address it is bound to, with its port.
  const std::string& endpoint() const { return endpoint_; }
  // Serves until it is shut down; says why it ended.
  std::string run();
  // Cancels everything that runs and waits at most `patience` for the workers. False: one of them is still busy.
  bool stop_workers(std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;
  struct Client {
    std::string name;
    std::unique_ptr<Worker> worker;
    Clock::time_point heard;
  };
  struct Incoming {
    std::string identity;
    std::vector<zmq::message_t> parts;  // header, arrays
    std::string fault;                  // set when it was too large to keep
  };

  std::optional<Incoming> receive();
  void handle(Incoming message);
  void dispatch(const std::string& identity, Header header, std::vector<zmq::message_t> arrays);
  void greet(const std::string& identity, const Hello& hello);
  void send(const std::string& identity, const std::vector<PartBytes>& parts);
  void forward_replies();
  void drop_idle_clients();
  bool make_room();
  void retire(Client client);

  const ServerOptions options_;
  const SolverFactory factory_;
  const ProcessWatch parent_;
  InputWatch input_;
  zmq::context_t context_{1};
  zmq::socket_t router_;
  zmq::socket_t replies_;
  std::string replies_endpoint_;
  std::string endpoint_;
  std::map<std::string, Client> clients_;
  std::vector<std::unique_ptr<Worker>> retired_;  // ending; joined when they have finished
  std::uint64_t next_session_;
  Clock::time_point heard_;
  std::string end_reason_;  // not empty: the loop ends
};

}  // namespace lappet
