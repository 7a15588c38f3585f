// The gate: how much it reads of whom, and who makes room. The tests play both the peers and ZeroMQ behind it.
#include "server/gate.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "lattice/refused.h"

namespace lappet {
namespace {

using std::chrono::milliseconds;

class GateTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = "/tmp/gate-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = name + "/inner";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path_.c_str(), path_.size());
    inner_listener_ = Descriptor(::socket(AF_UNIX, SOCK_STREAM, 0));
    ASSERT_EQ(::bind(inner_listener_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(inner_listener_.get(), 16), 0);
  }
  void TearDown() override {
    ::unlink(path_.c_str());
    ::rmdir(folder_.c_str());
  }

  void open(GateLimits limits = {}) { gate_.emplace("tcp://127.0.0.1:*", limits); }

  Descriptor connect() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(gate_->endpoint().substr(gate_->endpoint().rfind(':') + 1))));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    Descriptor peer(::socket(AF_INET, SOCK_STREAM, 0));
    EXPECT_EQ(::connect(peer.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    turn();
    return peer;
  }
  void turn(int count = 3) {
    for (int i = 0; i < count; ++i) {
      std::vector<zmq::pollitem_t> items;
      gate_->add_items(items);
      zmq::poll(items, milliseconds(20));
      gate_->serve(items);
    }
  }
  void write(const Descriptor& socket, std::size_t count) {
    const std::string bytes(count, 'x');
    EXPECT_EQ(::send(socket.get(), bytes.data(), count, MSG_NOSIGNAL | MSG_DONTWAIT), static_cast<ssize_t>(count));
    turn();
  }
  // What has come; -1: the other side has closed it.
  static ssize_t waiting(const Descriptor& socket) {
    std::string bytes(1 << 20, '\0');
    ssize_t all = 0;
    while (true) {
      const ssize_t count = ::recv(socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (count == 0) return -1;
      if (count < 0) return errno == EAGAIN ? all : -1;
      all += count;
    }
  }
  // A peer that began to speak, joined to its inner socket.
  std::pair<Gate::Number, Descriptor> join() {
    const std::vector<Gate::Number> arrived = gate_->take_arrived();
    EXPECT_EQ(arrived.size(), 1U);
    EXPECT_TRUE(gate_->join(arrived.at(0), path_));
    Descriptor inner(::accept(inner_listener_.get(), nullptr, nullptr));
    turn();
    return {arrived.at(0), std::move(inner)};
  }

  std::string folder_, path_;
  Descriptor inner_listener_;
  std::optional<Gate> gate_;
};

TEST_F(GateTest, BytesPassBothWays) {
  open();
  const Descriptor peer = connect();
  EXPECT_TRUE(gate_->take_arrived().empty()) << "who says nothing costs nothing";
  write(peer, 100);
  const auto [number, inner] = join();
  EXPECT_EQ(waiting(inner), 100);
  write(inner, 300);
  EXPECT_EQ(waiting(peer), 300);
}

TEST_F(GateTest, AStrangerMaySendSoMuchAndAUserAMessage) {
  open();
  const Descriptor peer = connect();
  write(peer, 4000);
  const auto [number, inner] = join();
  EXPECT_TRUE(gate_->admit(number, 10'000));
  write(peer, 9'999);
  turn();
  EXPECT_EQ(waiting(inner), 13'999);
  write(peer, 500);
  EXPECT_EQ(waiting(inner), 1) << "no more than its message may have";
  EXPECT_FALSE(gate_->is_flooding(number, Gate::Clock::now()));
  EXPECT_TRUE(gate_->is_flooding(number, Gate::Clock::now() + milliseconds(1100)));
  gate_->count_message(number);
  turn();
  EXPECT_EQ(waiting(inner), 499);
  EXPECT_FALSE(gate_->is_flooding(number, Gate::Clock::now() + milliseconds(1100)));

  const Descriptor stranger = connect();
  write(stranger, 100);
  const auto [other, behind] = join();
  write(stranger, 4100);
  EXPECT_EQ(waiting(stranger), -1);
  EXPECT_EQ(gate_->take_gone(), std::vector<Gate::Number>{other});
}

TEST_F(GateTest, TheOldestStrangerMakesRoomAndNoUser) {
  GateLimits limits;
  limits.unknown = 2;
  limits.known = 1;
  open(limits);
  const Descriptor user = connect();
  write(user, 1);
  const auto [number, inner] = join();
  EXPECT_TRUE(gate_->admit(number, 100));
  std::vector<Descriptor> strangers;
  for (int i = 0; i < 5; ++i) strangers.push_back(connect());
  EXPECT_EQ(gate_->unknown(), 2U);
  EXPECT_EQ(gate_->known(), 1U);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(waiting(strangers[i]), i < 3 ? -1 : 0) << i;
  EXPECT_EQ(waiting(user), 0);
  write(strangers[4], 1);
  const auto [next, behind] = join();
  EXPECT_FALSE(gate_->admit(next, 100)) << "the places of users are taken";
}

TEST_F(GateTest, WhoIsNotKnownInTimeIsClosed) {
  GateLimits limits;
  limits.handshake = milliseconds(150);
  open(limits);
  const Descriptor silent = connect();
  const Descriptor speaks = connect();
  write(speaks, 10);
  const auto [number, inner] = join();
  std::this_thread::sleep_for(milliseconds(200));
  turn();
  EXPECT_EQ(waiting(silent), -1);
  EXPECT_EQ(waiting(speaks), -1);
  EXPECT_EQ(gate_->unknown(), 0U);
}

TEST_F(GateTest, HandshakesOfOneAddressAreCounted) {
  GateLimits limits;
  limits.handshakes_per_second = 3.0;
  open(limits);
  std::vector<Descriptor> peers;
  for (int i = 0; i < 8; ++i) {
    peers.push_back(connect());
    write(peers.back(), 1);
  }
  const std::size_t let_in = gate_->take_arrived().size();
  EXPECT_GE(let_in, 3U);
  EXPECT_LE(let_in, 6U);
  EXPECT_EQ(gate_->take_gone().size(), 8U - let_in);
}

TEST_F(GateTest, WhoDoesNotReadHoldsUpItself) {
  open();
  const Descriptor peer = connect();
  write(peer, 1);
  auto [number, inner] = join();
  ASSERT_TRUE(gate_->admit(number, 100));
  const std::string bytes(1 << 20, 'x');
  std::size_t taken = 0;
  for (int i = 0; i < 200; ++i) {
    const ssize_t count = ::send(inner.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count > 0) taken += static_cast<std::size_t>(count);
    turn(1);
  }
  EXPECT_LT(taken, std::size_t{64} << 20) << "the gate itself holds back what is not read";
  inner.close();
  std::string read(std::size_t{1} << 16, ' ');
  std::size_t arrived = 0;
  for (int i = 0; i < 5000; ++i) {
    const ssize_t count = ::recv(peer.get(), read.data(), read.size(), MSG_DONTWAIT);
    if (count == 0) break;
    if (count > 0) arrived += static_cast<std::size_t>(count);
    turn(1);
  }
  EXPECT_EQ(arrived, taken) << "what was sent arrives, also after the sender's end";
}

TEST(GateAddress, WhatIsNoAddressIsRefused) {
  for (const std::string address :
       {"", "tcp://", "tcp://127.0.0.1", "ipc://x/y", "tcp://127.0.0.1:http", "tcp://:1:2:3"}) {
    EXPECT_THROW(Gate(address, {}), RefusedError) << address;
  }
}

}  // namespace
}  // namespace lappet
