// SPDX-License-Identifier: BSD-3-Clause
// Headers of others that most sources include. scripts/tidy.sh reads them once for all sources: half of the time of a
// source.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>
