// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace hrp {

// Calls work(i) for i in [0, count) on up to `jobs` threads. Results must go to slots of their own.
void parallel_for(int jobs, int count, const std::function<void(int)>& work);
// The same with the number of the thread, from 0, beside: for what each thread has a copy of.
void parallel_for(int jobs, int count, const std::function<void(int, int)>& work);

}  // namespace hrp
