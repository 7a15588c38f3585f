// What a campaign of mutated messages played: for people, and as the file that the repository keeps.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace lappet {

struct CampaignResult {
  std::uint64_t wanted = 0, messages = 0, seed = 0;  // how many were asked for, and played
  std::size_t findings = 0;
  double seconds = 0.0;
};

std::string sentence(const CampaignResult& result);
// As JSON, with the day and how the program was built. Throws std::runtime_error.
void write_result(const std::filesystem::path& file, const CampaignResult& result);

}  // namespace lappet
