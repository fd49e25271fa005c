#pragma once

// nlohmann's JSON, whose values are taken apart without memory. Its own destructor asks for some
// for the members of a value that has any, and is noexcept: where there is none the program would
// end. In place of <nlohmann/json.hpp>.
#include <iterator>
#include <memory>
#include <utility>

#include "planish/core/json_fwd.h"

#include <nlohmann/json.hpp>

namespace planish::json_parts {

// A value that could get no memory to become an array or object is one of null.
template <class Json>
Json* last_member(Json& value) noexcept {
  if (auto* array = value.template get_ptr<typename Json::array_t*>())
    return array->empty() ? nullptr : &array->back();
  auto* object = value.template get_ptr<typename Json::object_t*>();
  return object == nullptr || object->empty() ? nullptr : &std::prev(object->end())->second;
}

template <class Json>
void remove_last_member(Json& value) noexcept {
  if (auto* array = value.template get_ptr<typename Json::array_t*>()) return array->pop_back();
  auto& object = value.template get_ref<typename Json::object_t&>();
  object.erase(std::prev(object.end()));
}

/// Leaves null. However deep the members are nested: the way back up stands in them, each value
/// that is left in the place of the member that was taken out of it.
template <class Json>
void take_apart(Json& root) noexcept {
  Json value = std::move(root), above;
  for (;;) {
    Json* const member = last_member(value);
    if (member != nullptr && last_member(*member) != nullptr) {
      std::swap(*member, above);
      std::swap(above, value);
    } else if (member != nullptr) {
      remove_last_member(value);
    } else if (!above.is_null()) {
      Json further = std::move(*last_member(above));
      remove_last_member(above);
      value = std::move(above);
      above = std::move(further);
    } else {
      return;
    }
  }
}

template <class Held>
void remove(Held* held) noexcept {
  if (held == nullptr) return;
  std::destroy_at(held);
  std::allocator<Held>().deallocate(held, 1);
}

/// What a value of this type holds, as its destructor does.
template <class Json, class Value>
void remove_held(Value& value, typename Json::value_t type) noexcept {
  using Type = typename Json::value_t;
  if (type == Type::array) {
    if (value.array != nullptr)
      for (Json& member : *value.array) take_apart(member);
    remove(value.array);
  } else if (type == Type::object) {
    if (value.object != nullptr)
      for (auto& [key, member] : *value.object) take_apart(member);
    remove(value.object);
  } else if (type == Type::string) {
    remove(value.string);
  } else if (type == Type::binary) {
    remove(value.binary);
  }
}

}  // namespace planish::json_parts

// No page of the documentation has members of the library's.
/// \cond
template <>
inline void nlohmann::json::json_value::destroy(value_t type) {
  planish::json_parts::remove_held<json>(*this, type);
}
template <>
inline void nlohmann::ordered_json::json_value::destroy(value_t type) {
  planish::json_parts::remove_held<ordered_json>(*this, type);
}
/// \endcond
