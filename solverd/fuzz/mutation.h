// Spoils messages at random, the same way for the same seed: header fields, shapes, counts, numbers, lengths, order.
#pragma once
#include <cstdint>
#include <random>

#include "loose_message.h"

namespace lappet {

class Mutation {
 public:
  explicit Mutation(std::uint64_t seed) : random_(seed) {}

  // One to four changes; takes fields and arrays of `donor` now and then.
  RawMessage operator()(const RawMessage& message, const RawMessage& donor);
  // 0 to count - 1.
  std::size_t below(std::size_t count) { return count == 0 ? 0 : static_cast<std::size_t>(random_() % count); }
  bool once_in(std::size_t times) { return below(times) == 0; }

 private:
  void change(LooseMessage& message, LooseMessage donor);
  void change_header(LooseMessage& message);
  void change_value(Value& value, std::size_t depth);
  void change_shape(LooseMessage& message);
  void change_part(LooseMessage& message);
  void change_rows(LooseMessage& message);
  void change_number(LooseMessage& message);
  void nudge_numbers(LooseMessage& message);
  void take_over(LooseMessage& message, LooseMessage& donor);
  void change_bytes(PartBytes& bytes);
  Value any_value();
  double any_real(double near);
  std::int64_t any_whole(std::int64_t near);

  std::mt19937_64 random_;
};

}  // namespace lappet
