// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/error.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// Folder of cached maps: $GRAFT_CACHE_DIR, else $XDG_CACHE_HOME/graft, else
/// ~/.cache/graft; empty if none of these is an absolute path.
std::string reachCacheFolder();

/// File name of the map of a chain with these options: both decide it.
std::string reachCacheName(const Chain& chain, const ReachOptions& options);

/// The map of this chain: read from the cache, or built and put there. A cached
/// file that is damaged or of another chain is built anew, and a cache that
/// cannot be written is done without; both are warnings in `diagnostics`.
/// `path_used` receives the file read or written, or nothing if neither.
ReachMap cachedReachMap(const Chain& chain, const ReachOptions& options,
                        const ReachProgress& progress, std::string* path_used,
                        Diagnostics& diagnostics);

}  // namespace graft::lfd
