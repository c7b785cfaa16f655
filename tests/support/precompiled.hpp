// SPDX-License-Identifier: LGPL-2.1-or-later
// What most tests include and what takes the compiler longest to read: read once per room. No test
// depends on this file: with -Db_pch=false every source is compiled without it.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <ranges>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#if __has_include(<Eigen/Core>)
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#endif
#if __has_include(<gst/video/video.h>)
#include <gst/video/video.h>
#elif __has_include(<gst/gst.h>)
#include <gst/gst.h>
#endif
#if __has_include(<opencv2/core.hpp>)
#include <opencv2/core.hpp>
#endif
