// SPDX-License-Identifier: LGPL-2.1-or-later
#include "share/field-pool.hpp"

#include "share/sample-ring.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

namespace field_pool_test {

using haptic::FieldPool;

TEST(FieldPoolTest, GivesNoFieldToTwoAndNoneWhenAllAreTaken) {
  const auto pool = std::make_unique<FieldPool>();
  std::vector<FieldPool::Field> taken;
  for (std::size_t i = 0; i < FieldPool::kSlots; ++i) {
    taken.push_back(pool->acquire());
    ASSERT_TRUE(taken.back());
    for (std::size_t other = 0; other < i; ++other)
      ASSERT_NE(taken.back().get(), taken[other].get());
  }
  EXPECT_FALSE(pool->acquire());
  const auto *given_back = taken[7].get();
  taken[7] = {};
  EXPECT_EQ(pool->acquire().get(), given_back);
}

TEST(FieldPoolTest, AFieldThatComesBackKeepsItsMemory) {
  const auto pool = std::make_unique<FieldPool>();
  for (std::size_t i = 0; i < FieldPool::kSlots; ++i)
    pool->acquire()->cells.resize(100);
  EXPECT_GE(pool->acquire()->cells.capacity(), 100U);
}

TEST(FieldPoolTest, FieldsGoRoundBetweenTwoThreadsUntorn) {
  constexpr int kCount = 2'000;
  const auto pool = std::make_unique<FieldPool>();
  haptic::SampleRing<FieldPool::Field, 16> ring;
  std::jthread writer([&] {
    for (int i = 0; i < kCount;) {
      auto field = pool->acquire();
      if (!field) {
        std::this_thread::yield();
        continue;
      }
      field->interval = static_cast<std::uint64_t>(i);
      field->cells.assign(8, {static_cast<float>(i), 0, 1});
      i += ring.push(std::move(field)); // if the ring is full it goes back to the pool
    }
  });
  FieldPool::Field field;
  for (int i = 0; i < kCount;)
    if (ring.pop(field)) {
      ASSERT_EQ(field->interval, static_cast<std::uint64_t>(i));
      for (const auto &cell : field->cells)
        ASSERT_EQ(cell.velocity_x, static_cast<float>(i));
      ++i;
    } else {
      std::this_thread::yield();
    }
}

} // namespace field_pool_test
