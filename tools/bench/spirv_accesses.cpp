#include "bench/spirv_accesses.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <utility>

namespace planish::bench {

namespace {

using Words = std::vector<std::uint32_t>;

// Numbers of the SPIR-V specification, version 1.3.
enum Op : std::uint32_t {
  OpEntryPoint = 15,
  OpTypeVoid = 19,
  OpTypeBool = 20,
  OpTypeInt = 21,
  OpTypeFloat = 22,
  OpTypeVector = 23,
  OpTypeArray = 28,
  OpTypeRuntimeArray = 29,
  OpTypeStruct = 30,
  OpTypePointer = 32,
  OpTypeFunction = 33,
  OpConstant = 43,
  OpFunction = 54,
  OpFunctionParameter = 55,
  OpFunctionEnd = 56,
  OpFunctionCall = 57,
  OpVariable = 59,
  OpLoad = 61,
  OpStore = 62,
  OpAccessChain = 65,
  OpArrayLength = 68,
  OpDecorate = 71,
  OpMemberDecorate = 72,
  OpCompositeExtract = 81,
  OpIAdd = 128,
  OpIMul = 132,
  OpSelect = 169,
  OpULessThanEqual = 178,
  OpAtomicExchange = 229,
  OpAtomicIAdd = 234,
  OpAtomicXor = 242,
  OpLabel = 248,
  OpReturn = 253,
};
enum Decoration : std::uint32_t {
  Block = 2,
  ArrayStride = 6,
  BuiltIn = 11,
  Binding = 33,
  DescriptorSet = 34,
  Offset = 35,
};
constexpr std::uint32_t kInput = 1, kStorageBuffer = 12;  // storage classes
constexpr std::uint32_t kGlobalInvocationId = 28;
constexpr std::uint32_t kDeviceScope = 1;
constexpr std::uint32_t kHeadWords = 5, kBoundWord = 3;
constexpr std::uint32_t kWordBytes = 4;

struct Instruction {
  std::uint32_t op;
  std::span<const std::uint32_t> operands;
};

void put(Words& to, std::uint32_t op, std::span<const std::uint32_t> operands) {
  to.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | op);
  to.insert(to.end(), operands.begin(), operands.end());
}
void put(Words& to, std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
  put(to, op, std::span(operands.begin(), operands.size()));
}

class Rewriter {
 public:
  Rewriter(std::span<const std::uint32_t> module, std::vector<Access>& accesses)
      : head_(module.first(kHeadWords)), bound_(module[kBoundWord]), accesses_(accesses) {
    for (std::size_t i = kHeadWords; i < module.size(); i += module[i] >> 16)
      take({module[i] & 0xffff, module.subspan(i + 1, (module[i] >> 16) - 1)});
  }

  Words rewrite() {
    declare();
    const Words log_function = make_log_function();
    Words bodies;
    for (const Instruction& instruction : functions_) add(instruction, bodies);
    Words module(head_.begin(), head_.end());
    for (const Instruction& instruction : preamble_) {
      Words operands(instruction.operands.begin(), instruction.operands.end());
      if (instruction.op == OpEntryPoint && adds_invocation_) operands.push_back(invocation_);
      put(module, instruction.op, operands);
    }
    for (const Words* part :
         std::initializer_list<const Words*>{&decorations_, &types_, &bodies, &log_function})
      module.insert(module.end(), part->begin(), part->end());
    module[kBoundWord] = bound_;
    return module;
  }

 private:
  void take(const Instruction& instruction) {
    const auto [op, operands] = instruction;
    if (op == OpDecorate && operands.size() == 3)
      decorated_[{operands[0], operands[1]}] = operands[2];
    if (op == OpMemberDecorate && operands[2] == Offset)
      offsets_[{operands[0], operands[1]}] = operands[3];
    if (op == OpFunction || !functions_.empty()) {
      functions_.push_back(instruction);
    } else if (op == OpTypeVoid || !types_.empty()) {
      declared_.push_back(instruction);
      put(types_, op, operands);
      const bool is_type = op >= OpTypeVoid && op <= OpTypeFunction;
      typed_[operands[is_type ? 0 : 1]] = instruction;
    } else {
      preamble_.push_back(instruction);
    }
  }

  // The type of the same words, which may be there only once.
  std::uint32_t type(std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
    for (const Instruction& there : declared_)
      if (there.op == op && std::ranges::equal(there.operands.subspan(1), operands))
        return there.operands[0];
    return new_type(op, operands);
  }
  std::uint32_t new_type(std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
    Words all = {bound_++};
    all.insert(all.end(), operands.begin(), operands.end());
    put(types_, op, all);
    return all[0];
  }
  std::uint32_t constant(std::uint32_t value) {
    const auto [place, is_new] = constants_.try_emplace(value, bound_);
    if (is_new) put(types_, OpConstant, {word_, bound_++, value});
    return place->second;
  }
  std::uint32_t variable(std::uint32_t pointer, std::uint32_t storage) {
    put(types_, OpVariable, {pointer, bound_, storage});
    return bound_++;
  }

  void declare() {
    word_ = type(OpTypeInt, {32, 0});
    void_ = type(OpTypeVoid, {});
    bool_ = type(OpTypeBool, {});
    words_ = type(OpTypeVector, {word_, 3});
    word_pointer_ = type(OpTypePointer, {kStorageBuffer, word_});
    function_type_ = type(OpTypeFunction, {void_, word_, word_});
    const std::uint32_t array = new_type(OpTypeRuntimeArray, {word_});
    const std::uint32_t block = new_type(OpTypeStruct, {array});
    log_ = variable(new_type(OpTypePointer, {kStorageBuffer, block}), kStorageBuffer);
    put(decorations_, OpDecorate, {array, ArrayStride, kWordBytes});
    put(decorations_, OpDecorate, {block, Block});
    put(decorations_, OpMemberDecorate, {block, 0, Offset, 0});
    put(decorations_, OpDecorate, {log_, DescriptorSet, 1});
    put(decorations_, OpDecorate, {log_, Binding, 0});
    for (const auto& [of, value] : decorated_)
      if (of.second == BuiltIn && value == kGlobalInvocationId) invocation_ = of.first;
    adds_invocation_ = invocation_ == 0;
    if (!adds_invocation_) return;
    invocation_ = variable(type(OpTypePointer, {kInput, words_}), kInput);
    put(decorations_, OpDecorate, {invocation_, BuiltIn, kGlobalInvocationId});
  }

  // void log(access, offset): a record.
  Words make_log_function() {
    log_function_ = bound_++;
    const std::uint32_t access = bound_++, offset = bound_++;
    Words body;
    const auto value = [&](std::uint32_t op, std::uint32_t of_type,
                           std::initializer_list<std::uint32_t> operands) {
      Words all = {of_type, bound_++};
      all.insert(all.end(), operands.begin(), operands.end());
      put(body, op, all);
      return all[1];
    };
    const auto place = [&](std::uint32_t index) {
      return value(OpAccessChain, word_pointer_, {log_, constant(0), index});
    };
    put(body, OpFunction, {void_, log_function_, 0, function_type_});
    put(body, OpFunctionParameter, {word_, access});
    put(body, OpFunctionParameter, {word_, offset});
    put(body, OpLabel, {bound_++});
    const std::uint32_t next =
        value(OpAtomicIAdd, word_,
              {place(constant(0)), constant(kDeviceScope), constant(0), constant(kAccessWords)});
    const std::uint32_t end = value(OpIAdd, word_, {next, constant(kAccessWords)});
    const std::uint32_t length = value(OpArrayLength, word_, {log_, 0});
    const std::uint32_t fits = value(OpULessThanEqual, bool_, {end, length});
    const std::uint32_t first = value(OpSelect, word_, {fits, next, constant(kFirstAccess)});
    const std::uint32_t mark = value(OpLoad, word_, {place(constant(kAccessMark))});
    const std::uint32_t invocations = value(OpLoad, words_, {invocation_});
    const std::uint32_t invocation = value(OpCompositeExtract, word_, {invocations, 0});
    std::uint32_t k = 0;
    for (const std::uint32_t word : {mark, access, invocation, offset})
      put(body, OpStore, {place(value(OpIAdd, word_, {first, constant(k++)})), word});
    put(body, OpReturn, {});
    put(body, OpFunctionEnd, {});
    return body;
  }

  void add(const Instruction& instruction, Words& to) {
    const auto [op, operands] = instruction;
    if (op == OpLoad) log(operands[2], true, false, to);
    if (op == OpStore) log(operands[0], false, true, to);
    if (op >= OpAtomicExchange && op <= OpAtomicXor) log(operands[2], true, true, to);
    put(to, op, operands);
    if (op == OpAccessChain) follow(operands, to);
  }

  struct Pointer {
    std::uint32_t offset, bytes;
  };

  // Where a chain of indices leads to, in bytes from the start of its buffer.
  void follow(std::span<const std::uint32_t> chain, Words& to) {
    const auto base = typed_.find(chain[2]);
    if (base == typed_.end() || base->second.op != OpVariable ||
        base->second.operands[2] != kStorageBuffer)
      return;
    std::uint32_t at = typed_.at(base->second.operands[0]).operands[2];
    std::uint32_t sum = constant(0);
    for (const std::uint32_t index : chain.subspan(3)) {
      const auto [op, operands] = typed_.at(at);
      if (op == OpTypeStruct) {
        const std::uint32_t member = typed_.at(index).operands[2];
        sum = add_words(OpIAdd, sum, constant(offsets_.at({at, member})), to);
        at = operands[1 + member];
      } else {
        const std::uint32_t stride =
            op == OpTypeVector ? kWordBytes : decorated_.at({at, ArrayStride});
        sum = add_words(OpIAdd, sum, add_words(OpIMul, index, constant(stride), to), to);
        at = operands[1];
      }
    }
    pointers_[chain[1]] = {sum, bytes_of(at)};
  }
  std::uint32_t add_words(std::uint32_t op, std::uint32_t a, std::uint32_t b, Words& to) {
    put(to, op, {word_, bound_, a, b});
    return bound_++;
  }

  [[nodiscard]] std::uint32_t bytes_of(std::uint32_t type) const {
    const auto [op, operands] = typed_.at(type);
    if (op == OpTypeVector) return operands[2] * kWordBytes;
    if (op != OpTypeStruct) return kWordBytes;
    std::uint32_t bytes = 0;
    for (const std::uint32_t member : operands.subspan(1)) bytes += bytes_of(member);
    return bytes;
  }

  void log(std::uint32_t pointer, bool reads, bool writes, Words& to) {
    const auto found = pointers_.find(pointer);
    if (found == pointers_.end()) return;
    put(to, OpFunctionCall,
        {void_, bound_++, log_function_, constant(static_cast<std::uint32_t>(accesses_.size())),
         found->second.offset});
    accesses_.push_back({found->second.bytes, reads, writes});
  }

  std::span<const std::uint32_t> head_;
  std::uint32_t bound_;
  std::vector<Access>& accesses_;
  std::vector<Instruction> preamble_, declared_, functions_;
  std::map<std::uint32_t, Instruction> typed_;  // types, constants and variables by their number
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> decorated_, offsets_;
  std::map<std::uint32_t, std::uint32_t> constants_;
  std::map<std::uint32_t, Pointer> pointers_;
  Words decorations_, types_;
  std::uint32_t word_ = 0, void_ = 0, bool_ = 0, words_ = 0, word_pointer_ = 0, function_type_ = 0;
  std::uint32_t log_ = 0, invocation_ = 0, log_function_ = 0;
  bool adds_invocation_ = false;
};

}  // namespace

std::vector<std::uint32_t> with_access_log(std::span<const std::uint32_t> module,
                                           std::vector<Access>& accesses) {
  return Rewriter(module, accesses).rewrite();
}

}  // namespace planish::bench
