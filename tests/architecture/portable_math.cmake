# Results have the same bits on every machine: what makes them takes its sines from core/portable_math.h, not from the
# standard library, whose last bits are the system's and the processor's.
file(GLOB_RECURSE sources ${SOURCE}/src/*.cpp ${SOURCE}/src/*.h ${SOURCE}/tools/dev/make_scenes/*.cpp
     ${SOURCE}/tools/dev/make_scenes/*.h)
set(elementary
    "(std|glm)::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|cbrt)f?[(]")
set(count 0)
foreach(source ${sources})
  if(source MATCHES "core/portable_math.cpp$")
    continue()
  endif()
  file(STRINGS ${source} lines REGEX ${elementary})
  foreach(line ${lines})
    message("${source}: ${line}")
    math(EXPR count "${count} + 1")
  endforeach()
endforeach()
list(LENGTH sources read)
if(read LESS 300)
  message(FATAL_ERROR "only ${read} sources were found")
endif()
if(count GREATER 0)
  message(FATAL_ERROR "${count} calls of the standard library's elementary functions; take core/portable_math.h's")
endif()
