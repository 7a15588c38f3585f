// The daemon's loop against a session that solves nothing: order, tokens, cancel, ping, silence, bounds.
#include "server/server.h"

#include <gtest/gtest.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#else
#include <unistd.h>
#endif

#include <algorithm>
#include <array>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>

#include "lattice/refused.h"

namespace lappet {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// Solves by waiting until it is cancelled, when the frame's time is negative; fails in the ways that its time says.
class IdlePort final : public SolverPort {
 public:
  EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>&) override {
    EpochReport report;
    report.cells = static_cast<std::int32_t>(epoch.surface.triangles.size());
    return report;
  }
  void set_state(const SolverState&) override {}
  FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                    const std::atomic<bool>& cancel) override {
    if (frame.time == 98.0) throw std::runtime_error("a fault");
    if (frame.time == 99.0) throw std::bad_alloc();
    const auto end = Clock::now() + std::chrono::seconds(20);
    while (frame.time < 0.0 && Clock::now() < end) {
      if (cancel.load()) throw RefusedError(ErrorCode::kCancelled, "The solve was cancelled.");
      progress({frame.time, 1, 0.5, 0.0});
      std::this_thread::sleep_for(milliseconds(2));
    }
    FrameOutput output;
    output.time = frame.time;
    output.converged = true;
    return output;
  }
};

bool make_pipe(std::array<int, 2>& ends) {
#ifdef _WIN32
  return ::_pipe(ends.data(), 256, _O_BINARY | _O_NOINHERIT) == 0;
#else
  return ::pipe(ends.data()) == 0;
#endif
}

class ServerTest : public testing::Test {
 protected:
  void serve(ServerOptions options = {}) {
    options.token = "secret";
    server_ = std::make_unique<Server>(std::move(options), [](const SessionSettings& settings) {
      if (settings.spacing <= 0.0) throw RefusedError(ErrorCode::kInvalidInput, "The spacing must be larger than 0.");
      return std::make_unique<IdlePort>();
    });
    reason_ = std::async(std::launch::async, [this] { return server_->run(); });
  }

  void TearDown() override {
    if (!server_) return;
    if (reason_.valid()) {
      Peer last(*this);
      last.greet_patiently();
      last.ask("shutdown");
      EXPECT_EQ(reason_.wait_for(std::chrono::seconds(5)), std::future_status::ready);
    }
    EXPECT_TRUE(server_->stop_workers(std::chrono::seconds(5)));
  }

  struct Reply {
    std::string type;
    std::uint64_t id = 0;
    std::string code;
    std::string message;
  };

  class Peer {
   public:
    explicit Peer(ServerTest& test) : socket_(test.context_, zmq::socket_type::dealer) {
      socket_.set(zmq::sockopt::linger, 0);
      socket_.set(zmq::sockopt::rcvtimeo, 5000);
      socket_.connect(test.server_->endpoint());
    }

    std::uint64_t send(MessageWriter message) { return send(message.finish()); }
    std::uint64_t send(const std::vector<PartBytes>& parts) {
      for (std::size_t i = 0; i < parts.size(); ++i) {
        socket_.send(zmq::buffer(parts[i]), i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
      }
      return next_id_++;
    }
    MessageWriter message(const std::string& type) { return {type, next_id_}; }

    // The next reply that is not progress; progress is counted.
    Reply receive() {
      while (true) {
        zmq::message_t frame;
        if (!socket_.recv(frame)) return {"nothing", 0, "", ""};
        const Header header = decode_header({static_cast<const std::byte*>(frame.data()), frame.size()});
        while (frame.more()) static_cast<void>(socket_.recv(frame));
        if (header.type == "progress") {
          ++progress_;
          continue;
        }
        Reply reply{header.type, header.id, "", ""};
        if (header.type == "error") {
          reply.code = std::get<std::string>(header.fields.at("code"));
          reply.message = std::get<std::string>(header.fields.at("message"));
        }
        return reply;
      }
    }

    Reply ask(const std::string& type) {
      send(message(type));
      return receive();
    }
    Reply greet(const std::string& token = "secret") {
      send(message("hello").field("token", token).field("client", std::string("test")));
      return receive();
    }
    // A client that has left makes room when its worker has ended.
    Reply greet_patiently() {
      const auto end = Clock::now() + std::chrono::seconds(5);
      Reply reply = greet();
      while (reply.type != "welcome" && Clock::now() < end) {
        std::this_thread::sleep_for(milliseconds(20));
        reply = greet();
      }
      return reply;
    }
    std::uint64_t send_open(double spacing = 1.0) {
      const std::vector<Value> zero = {0.0, 0.0, 0.0};
      const Fields settings = {{"spacing", spacing},
                               {"fine_ratio", std::int64_t{4}},
                               {"origin", zero},
                               {"quadrature", std::int64_t{1}},
                               {"precision", std::string("float")},
                               {"tolerance", 1e-3},
                               {"gap_tolerance", 1e-3},
                               {"max_newton", std::int64_t{9}},
                               {"bed_stiffness", 1.0},
                               {"bed_shear", 0.5},
                               {"gravity", zero},
                               {"time_budget", 0.0},
                               {"memory_budget", std::int64_t{1} << 30},
                               {"threads", std::int64_t{1}},
                               {"sutures", std::int64_t{0}},
                               {"retractors", std::int64_t{0}}};
      const Fields material = {
          {"model", std::string("corotated")}, {"youngs_modulus", 50.0}, {"poissons_ratio", 0.4}, {"density", 1000.0}};
      return send(message("open").field("settings", settings).field("materials", std::vector<Value>{material}));
    }
    std::uint64_t send_epoch() {
      const std::vector<double> points(9, 0.5);
      const std::vector<std::int32_t> triangle = {0, 1, 2};
      const std::vector<std::uint8_t> mark = {0};
      const std::vector<std::int32_t> grip = {-1};
      return send(message("epoch")
                      .field("index", std::int64_t{0})
                      .array("points", std::span<const double>(points), {3, 3})
                      .array("triangles", std::span<const std::int32_t>(triangle), {1, 3})
                      .array("fixed", std::span<const std::uint8_t>(mark), {1})
                      .array("support", std::span<const std::uint8_t>(mark), {1})
                      .array("grip", std::span<const std::int32_t>(grip), {1})
                      .array("landmarks", std::span<const double>(), {0, 3})
                      .array("landmark_triangles", std::span<const std::int32_t>(), {0}));
    }
    std::uint64_t send_solve(double time) {
      const std::span<const double> reals;
      const std::span<const std::int32_t> wholes;
      return send(message("solve")
                      .field("time", time)
                      .array("hook_anchors", reals, {0, 3})
                      .array("hook_triangles", wholes, {0})
                      .array("hook_targets", reals, {0, 3})
                      .array("hook_stiffness", reals, {0})
                      .array("suture_index", wholes, {0})
                      .array("suture_anchors", reals, {0, 2, 3})
                      .array("suture_triangles", wholes, {0, 2})
                      .array("suture_closure", reals, {0})
                      .array("suture_stiffness", reals, {0})
                      .array("retractor_index", wholes, {0})
                      .array("retractor_motion", reals, {0, 4, 4}));
    }
    void prepare() {
      EXPECT_EQ(greet().type, "welcome");
      send_open();
      EXPECT_EQ(receive().type, "opened");
      send_epoch();
      EXPECT_EQ(receive().type, "lattice");
    }
    int progress() const { return progress_; }

   private:
    zmq::socket_t socket_;
    std::uint64_t next_id_ = 1;
    int progress_ = 0;
  };

  zmq::context_t context_{1};
  std::unique_ptr<Server> server_;
  std::future<std::string> reason_;
};

TEST_F(ServerTest, NothingIsServedBeforeTheRightToken) {
  serve();
  Peer peer(*this);
  EXPECT_EQ(peer.ask("ping").code, "out_of_order");
  EXPECT_EQ(peer.ask("shutdown").code, "out_of_order");
  EXPECT_EQ(peer.greet("wrong").code, "unauthorized");
  EXPECT_EQ(peer.greet("").code, "unauthorized");
  EXPECT_EQ(peer.greet("secret ").code, "unauthorized");
  EXPECT_EQ(peer.ask("ping").code, "out_of_order");
  EXPECT_EQ(peer.greet().type, "welcome");
  EXPECT_EQ(peer.ask("ping").type, "pong");
}

TEST_F(ServerTest, WhatComesTooEarlyIsRefusedAndTheSessionGoesOn) {
  serve();
  Peer peer(*this);
  peer.greet();
  peer.send_epoch();
  EXPECT_EQ(peer.receive().code, "out_of_order");
  peer.send_open();
  EXPECT_EQ(peer.receive().type, "opened");
  peer.send_solve(1.0);
  EXPECT_EQ(peer.receive().code, "out_of_order");
  peer.send_open();
  EXPECT_EQ(peer.receive().code, "out_of_order");
  peer.send_epoch();
  EXPECT_EQ(peer.receive().type, "lattice");
  peer.send(MessageWriter("close", 77, 12345));
  EXPECT_EQ(peer.receive().code, "out_of_order");
  peer.send_solve(1.0);
  EXPECT_EQ(peer.receive().type, "frame");
  EXPECT_EQ(peer.ask("close").type, "accepted");
  peer.send_solve(1.0);
  EXPECT_EQ(peer.receive().code, "out_of_order");
  peer.send_open(-1.0);
  EXPECT_EQ(peer.receive().code, "invalid_input");
}

TEST_F(ServerTest, PingAndCancelAreAnsweredWhileASolveRuns) {
  serve();
  Peer peer(*this);
  peer.prepare();
  const std::uint64_t running = peer.send_solve(-1.0);
  const std::uint64_t waiting = peer.send_solve(-2.0);
  const auto begun = Clock::now();
  EXPECT_EQ(peer.ask("ping").type, "pong");
  std::this_thread::sleep_for(milliseconds(150));
  peer.send(peer.message("cancel"));
  std::vector<Reply> replies = {peer.receive(), peer.receive(), peer.receive()};
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds(2));
  EXPECT_EQ(std::ranges::count(replies, "accepted", &Reply::type), 1);
  for (const std::uint64_t id : {running, waiting}) {
    const auto reply = std::ranges::find(replies, id, &Reply::id);
    ASSERT_NE(reply, replies.end());
    EXPECT_EQ(reply->code, "cancelled");
  }
  EXPECT_GE(peer.progress(), 2);
  EXPECT_LE(peer.progress(), 20) << "progress is not throttled";
  peer.send_solve(5.0);
  EXPECT_EQ(peer.receive().type, "frame") << "a cancel acts on the solves before it only";
}

TEST_F(ServerTest, FaultsOfTheSolverAreRepliesAndTheDaemonLivesOn) {
  serve();
  Peer peer(*this);
  peer.prepare();
  peer.send_solve(98.0);
  const Reply fault = peer.receive();
  EXPECT_EQ(fault.code, "internal");
  EXPECT_NE(fault.message.find("a fault"), std::string::npos);
  peer.send_solve(99.0);
  EXPECT_EQ(peer.receive().code, "memory_budget");
  peer.send_solve(1.0);
  EXPECT_EQ(peer.receive().type, "frame");
}

TEST_F(ServerTest, TheQueueOfAClientIsBounded) {
  serve();
  Peer peer(*this);
  peer.prepare();
  constexpr std::size_t kSent = Worker::kMaxWaiting + 5;
  for (std::size_t i = 0; i < kSent; ++i) peer.send_solve(-1.0);
  peer.send(peer.message("cancel"));
  std::vector<Reply> replies;
  for (std::size_t i = 0; i < kSent + 1; ++i) replies.push_back(peer.receive());
  const auto refused = std::ranges::count(replies, "out_of_order", &Reply::code);
  const auto cancelled = std::ranges::count(replies, "cancelled", &Reply::code);
  EXPECT_GE(refused, 4);
  EXPECT_LE(refused, 5);  // 5 where the worker had not taken the first one yet
  EXPECT_EQ(refused + cancelled, static_cast<std::ptrdiff_t>(kSent));
}

TEST_F(ServerTest, OneClientDoesNotWaitForAnotherAndTheirNumberIsBounded) {
  ServerOptions options;
  options.max_clients = 2;
  serve(options);
  Peer first(*this);
  Peer second(*this);
  Peer third(*this);
  first.prepare();
  first.send_solve(-1.0);
  second.prepare();
  second.send_solve(3.0);
  EXPECT_EQ(second.receive().type, "frame");
  EXPECT_EQ(third.greet().code, "out_of_order");
  EXPECT_EQ(second.ask("cancel").type, "accepted") << "cancels its own solves only";
  EXPECT_EQ(first.ask("ping").type, "pong");
  EXPECT_EQ(second.ask("bye").type, "accepted");
  EXPECT_EQ(second.ask("ping").code, "out_of_order");
  EXPECT_EQ(third.greet_patiently().type, "welcome");
  EXPECT_EQ(first.ask("bye").type, "accepted");
}

TEST_F(ServerTest, WhereThereIsNoOtherPlaceThatOfAClientThatVanishedIsGivenAway) {
  ServerOptions options;
  options.max_clients = 2;
  options.silence_where_full = milliseconds(600);
  serve(options);
  Peer lives(*this);
  Peer vanished(*this);
  Peer waiting(*this);
  EXPECT_EQ(lives.greet().type, "welcome");
  EXPECT_EQ(vanished.greet().type, "welcome");
  EXPECT_EQ(waiting.greet().code, "out_of_order");
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(milliseconds(100));
    EXPECT_EQ(lives.ask("ping").type, "pong");
  }
  EXPECT_EQ(waiting.greet().type, "welcome");
  EXPECT_EQ(vanished.ask("ping").code, "out_of_order");
  EXPECT_EQ(vanished.greet().code, "out_of_order") << "who is heard keeps their place";
  EXPECT_EQ(lives.ask("ping").type, "pong");
}

TEST_F(ServerTest, BrokenMessagesGetAnErrorWithTheirIdAndNothingElse) {
  serve();
  Peer peer(*this);
  peer.prepare();
  const auto text = [](const std::string& bytes) {
    const auto view = std::as_bytes(std::span(bytes));
    return PartBytes(view.begin(), view.end());
  };
  peer.send(std::vector<PartBytes>{text("not msgpack")});
  Reply reply = peer.receive();
  EXPECT_EQ(reply.code, "malformed");
  EXPECT_EQ(reply.id, 0U);
  peer.send(MessageWriter("dance", 41));
  reply = peer.receive();
  EXPECT_EQ(reply.code, "malformed");
  EXPECT_EQ(reply.id, 41U);
  std::vector<PartBytes> many = MessageWriter("ping", 42).finish();
  for (std::size_t i = 0; i < 3 * kMaxArrays; ++i) many.push_back(text("x"));
  peer.send(many);
  reply = peer.receive();
  EXPECT_EQ(reply.code, "malformed");
  EXPECT_EQ(reply.id, 42U);
  peer.send(MessageWriter("ping", 43).field("extra", true));
  EXPECT_EQ(peer.receive().code, "malformed");
  peer.send_solve(1.0);
  EXPECT_EQ(peer.receive().type, "frame");
}

TEST_F(ServerTest, ItEndsWhenItHearsNothing) {
  ServerOptions options;
  options.silence = milliseconds(700);
  serve(options);
  Peer peer(*this);
  peer.greet();
  const auto begun = Clock::now();
  while (Clock::now() - begun < milliseconds(1500)) {
    EXPECT_EQ(peer.ask("ping").type, "pong");
    std::this_thread::sleep_for(milliseconds(100));
  }
  ASSERT_EQ(reason_.wait_for(std::chrono::seconds(3)), std::future_status::ready);
  EXPECT_NE(reason_.get().find("heard nothing"), std::string::npos);
}

TEST_F(ServerTest, ItEndsWhenItsInputCloses) {
  std::array<int, 2> pipe_ends{};
  ASSERT_TRUE(make_pipe(pipe_ends));
  ServerOptions options;
  options.input = pipe_ends[0];
  serve(options);
  Peer peer(*this);
  peer.prepare();
  peer.send_solve(-1.0);
  ASSERT_EQ(::write(pipe_ends[1], "x", 1), 1);
  EXPECT_EQ(reason_.wait_for(milliseconds(400)), std::future_status::timeout) << "a byte is no end of file";
  ::close(pipe_ends[1]);
  ASSERT_EQ(reason_.wait_for(std::chrono::seconds(2)), std::future_status::ready);
  EXPECT_NE(reason_.get().find("standard input"), std::string::npos);
  ::close(pipe_ends[0]);
}

TEST(ServerOptions, AnEmptyTokenAndAnAddressInUseAreRefused) {
  const auto none = [](const SessionSettings&) -> std::unique_ptr<SolverPort> { return nullptr; };
  EXPECT_THROW(Server(ServerOptions{}, none), RefusedError);
  ServerOptions options;
  options.token = "secret";
  const Server first(options, none);
  options.address = first.endpoint();
  EXPECT_THROW(Server(options, none), RefusedError);
}

}  // namespace
}  // namespace lappet
