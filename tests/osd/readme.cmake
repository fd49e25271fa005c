# Fails when README.md does not show the example as it is compiled.
# cmake -DREADME=<file> -DEXAMPLE=<file> -P readme.cmake
file(READ ${README} readme)
file(READ ${EXAMPLE} example)
string(FIND "${readme}" "```cpp\n${example}```" place)
if(place EQUAL -1)
  message(FATAL_ERROR "${README} does not show ${EXAMPLE}")
endif()
