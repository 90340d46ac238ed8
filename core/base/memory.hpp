// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace graft {

/// Bytes that the process may still take: the least of what the machine has free, what
/// control groups leave it, and what RLIMIT_AS leaves. Infinite where nothing tells.
double availableMemory();

/// Of that what control groups (versions 1 and 2) leave: the least of the process's groups and
/// their parents, page cache that can be dropped not counted. `root`: where /proc and /sys
/// stand, "" = those of the system.
double availableInGroups(const std::string& root = "");

/// "41.3 GB", three digits, powers of 1000.
std::string formatBytes(double bytes);

bool fitsIntoMemory(double bytes);

/// Throws Error(kNoResult) "<what> needs 41.3 GB, 11.9 GB are free<advice>" where `bytes`
/// are more than there are: said beforehand, for who asks for too much on a system that
/// promises memory it does not have is killed without a word.
void requireMemory(double bytes, const std::string& what, const std::string& advice = "");

}  // namespace graft
