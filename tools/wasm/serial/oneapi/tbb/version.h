#pragma once

#define TBB_VERSION_MAJOR 0
#define TBB_VERSION_MINOR 0
#define TBB_VERSION_STRING "none: one thread"
extern "C" inline const char* TBB_runtime_version() { return TBB_VERSION_STRING; }
