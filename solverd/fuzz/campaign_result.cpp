#include "campaign_result.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <span>

#include "conversation.h"

namespace lappet {
namespace {

std::string today() {
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now())};
  char text[16];
  std::snprintf(text, sizeof text, "%04d-%02u-%02u", static_cast<int>(day.year()), static_cast<unsigned>(day.month()),
                static_cast<unsigned>(day.day()));
  return text;
}

}  // namespace

std::string sentence(const CampaignResult& result) {
  return std::to_string(result.messages) + " mutated messages with the seed " + std::to_string(result.seed) + " in " +
         std::to_string(std::lround(result.seconds)) + " s: " + std::to_string(result.findings) + " findings";
}

void write_result(const std::filesystem::path& file, const CampaignResult& result) {
  const std::string built = LAPPET_SANITIZER;
  const std::string text = "{\n  \"date\": \"" + today() + "\",\n  \"sanitizers\": \"" + built +
                           "\",\n  \"seed\": " + std::to_string(result.seed) +
                           ",\n  \"wanted\": " + std::to_string(result.wanted) +
                           ",\n  \"messages\": " + std::to_string(result.messages) +
                           ",\n  \"findings\": " + std::to_string(result.findings) +
                           ",\n  \"seconds\": " + std::to_string(std::lround(result.seconds)) + "\n}\n";
  save(file, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace lappet
