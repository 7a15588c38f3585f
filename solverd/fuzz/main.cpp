// solverd_fuzz: plays the corpus, then mutated messages, in child processes, so that one that ends is seen, kept as a
// file and followed by the next block.
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "campaign.h"
#include "campaign_result.h"
#include "replay.h"

// Of the address sanitizer, where there is one: what is too large to allocate throws, as it does without.
extern "C" const char* __asan_default_options() { return "allocator_may_return_null=1"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace lappet {
namespace {

// Processor time of one message; a child that takes longer is ended by the timer.
constexpr int kMaxSeconds = 30;
constexpr std::size_t kMaxRecord = std::size_t{16} << 20;
constexpr std::size_t kMaxFindings = 20;
constexpr std::chrono::milliseconds kBetweenLooks{50};
constexpr std::chrono::seconds kBetweenResults{30};

volatile std::sig_atomic_t is_stopped = 0;

// What a child plays, in memory that outlives it.
struct Record {
  std::uint64_t block = 0;
  std::uint64_t blocks_done = 0;
  std::uint32_t messages = 0;
  std::uint64_t used = 0;
  std::byte bytes[kMaxRecord];

  void begin(std::uint64_t number) {
    block = number;
    messages = 0;
    used = 0;
  }
  void add(const RawMessage& message) {
    const std::vector<std::byte> written = write_conversation({message});
    const std::span<const std::byte> body = std::span(written).subspan(sizeof messages);
    if (used + body.size() > kMaxRecord) return;
    std::memcpy(bytes + used, body.data(), body.size());
    used += body.size();
    ++messages;
  }
  std::vector<std::byte> file() const {
    std::vector<std::byte> result(sizeof messages + used);
    std::memcpy(result.data(), &messages, sizeof messages);
    std::memcpy(result.data() + sizeof messages, bytes, used);
    return result;
  }
};

void start_timer() {
  const itimerval limit{{0, 0}, {kMaxSeconds, 0}};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
}

// Runs body in a child process; its id.
template <class Body>
pid_t in_child(const Body& body) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::signal(SIGINT, SIG_IGN);  // the parent is told to stop, and ends its children
  ::signal(SIGTERM, SIG_DFL);
  try {
    body();
    std::fflush(nullptr);
    std::_Exit(0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  std::_Exit(1);
}

bool ends_well(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
  }
  if (WIFSIGNALED(status)) std::fprintf(stderr, "ended by the signal %s\n", ::strsignal(WTERMSIG(status)));
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool plays_well(const Conversation& conversation) {
  return ends_well(in_child([&] {
    start_timer();
    const std::vector<std::byte> bytes = write_conversation(conversation);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }));
}

// Leaves out messages for as long as what is left still fails.
Conversation smaller(Conversation failing) {
  for (std::size_t i = failing.size(); i-- > 0;) {
    Conversation without = failing;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (!plays_well(without)) failing = std::move(without);
  }
  return failing;
}

struct Wanted {
  std::uint64_t messages = 0, seed = 1, session_every = 16;
  std::size_t jobs = 1;
};

class Campaign {
 public:
  Campaign(std::vector<NamedConversation> corpus, const Wanted& wanted, std::filesystem::path findings)
      : corpus_(std::move(corpus)),
        wanted_(wanted),
        blocks_((wanted.messages + kBlock - 1) / kBlock),
        findings_(std::move(findings)) {}

  // Plays every block, unless SIGINT or SIGTERM comes; calls `told` now and then.
  void run(const std::function<void()>& told) {
    for (std::size_t k = 0; k < wanted_.jobs; ++k) {
      void* memory =
          ::mmap(nullptr, sizeof(Record), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (memory == MAP_FAILED) throw std::runtime_error("no memory for the records");
      records_.push_back(new (memory) Record);
      children_.push_back(start(k, k));
    }
    auto last = std::chrono::steady_clock::now();
    while (is_stopped == 0 && std::ranges::any_of(children_, [](pid_t child) { return child != 0; })) {
      if (!look()) std::this_thread::sleep_for(kBetweenLooks);
      if (std::chrono::steady_clock::now() - last < kBetweenResults) continue;
      last = std::chrono::steady_clock::now();
      told();
    }
    for (pid_t& child : children_) {
      if (child == 0) continue;
      ::kill(child, SIGKILL);
      ::waitpid(child, nullptr, 0);
    }
  }
  std::size_t findings() const { return found_; }
  std::uint64_t messages() const {
    std::uint64_t blocks = 0;
    for (const Record* record : records_) blocks += record->blocks_done;
    return blocks * kBlock;
  }

 private:
  pid_t start(std::size_t k, std::uint64_t first) {
    return in_child([&] {
      Record& record = *records_[k];
      for (std::uint64_t block = first; block < blocks_; block += wanted_.jobs) {
        record.begin(block);
        play_block(corpus_, wanted_.seed, block, wanted_.session_every, [&](const RawMessage& message) {
          record.add(message);
          start_timer();
        });
        ++record.blocks_done;
      }
    });
  }
  // Whether a child has ended; one that ended badly is followed by another, from its next block on.
  bool look() {
    int status = 0;
    const pid_t ended = ::waitpid(-1, &status, WNOHANG);
    const auto child = std::ranges::find(children_, ended);
    if (ended <= 0 || child == children_.end()) return false;
    *child = 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
    const auto k = static_cast<std::size_t>(child - children_.begin());
    keep(*records_[k], status);
    if (found_ < kMaxFindings) *child = start(k, records_[k]->block + wanted_.jobs);
    return true;
  }
  void keep(const Record& record, int status) {
    std::filesystem::create_directories(findings_);
    const auto file =
        findings_ / ("found-" + std::to_string(wanted_.seed) + "-" + std::to_string(record.block) + ".messages");
    save(file, record.file());
    ++found_;
    std::fprintf(stderr, "block %llu ended (%s %d); its messages are in %s\n",
                 static_cast<unsigned long long>(record.block), WIFSIGNALED(status) ? "signal" : "status",
                 WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status), file.c_str());
  }

  std::vector<NamedConversation> corpus_;
  Wanted wanted_;
  std::uint64_t blocks_;
  std::filesystem::path findings_;
  std::vector<Record*> records_;
  std::vector<pid_t> children_;
  std::size_t found_ = 0;
};

int play_files(const std::vector<NamedConversation>& corpus) {
  int failed = 0;
  for (const NamedConversation& conversation : corpus) {
    if (plays_well(conversation.messages)) continue;
    std::printf("%s: failed\n", conversation.name.c_str());
    ++failed;
  }
  std::printf("%zu conversations of the corpus, %d failed\n", corpus.size(), failed);
  return failed;
}

// The exit status.
int play_campaign(const std::vector<NamedConversation>& corpus, const Wanted& wanted, const std::string& findings,
                  const std::string& result_file) {
  const auto begin = std::chrono::steady_clock::now();
  Campaign campaign(corpus, wanted, findings);
  const auto result = [&] {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    return CampaignResult{wanted.messages, campaign.messages(), wanted.seed, campaign.findings(), seconds.count()};
  };
  const auto told = [&] {
    if (!result_file.empty()) write_result(result_file, result());
  };
  std::signal(SIGINT, [](int) { is_stopped = 1; });
  std::signal(SIGTERM, [](int) { is_stopped = 1; });
  campaign.run(told);
  told();
  std::printf("%s\n", sentence(result()).c_str());
  return campaign.findings() > 0 ? 1 : 0;
}

}  // namespace
}  // namespace lappet

int main(int argc, char** argv) {
  CLI::App app("Plays recorded and mutated messages against the daemon's decoding and sessions.", "solverd_fuzz");
  std::string place, findings = "findings", reduced, result_file;
  lappet::Wanted wanted;
  app.add_option("corpus", place, "A .messages file, or a folder of such")->required();
  app.add_option("--messages", wanted.messages, "Mutated messages to play after the corpus")->capture_default_str();
  app.add_option("--seed", wanted.seed, "What they depend on")->capture_default_str();
  app.add_option("--session-every", wanted.session_every, "Of so many blocks of 64 messages one goes to a session")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--jobs", wanted.jobs, "Processes")->capture_default_str()->check(CLI::Range(1, 256));
  app.add_option("--findings", findings, "Where messages that fail are written")->capture_default_str();
  app.add_option("--result", result_file, "Write there what was played");
  app.add_option("--reduce", reduced, "Write the smallest part of the file that still fails here");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::critical);
  try {
    const auto corpus = lappet::load_corpus(place);
    if (!reduced.empty()) {
      lappet::save(reduced, lappet::write_conversation(lappet::smaller(corpus.front().messages)));
      return 0;
    }
    if (lappet::play_files(corpus) > 0) return 1;
    return lappet::play_campaign(corpus, wanted, findings, result_file);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "solverd_fuzz: %s\n", error.what());
    return 2;
  }
}
