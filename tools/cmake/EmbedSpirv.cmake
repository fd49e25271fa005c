# Writes the words of INPUT as a constexpr array NAME of NAMESPACE into the header OUTPUT.
file(READ ${INPUT} hex HEX)
# SPIR-V as compiled here is little-endian.
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${hex}")
file(WRITE ${OUTPUT} "#pragma once
#include <cstdint>
namespace ${NAMESPACE} {
inline constexpr std::uint32_t ${NAME}[] = {
${words}};
}  // namespace ${NAMESPACE}
")
