#include "devices.h"

#include <algorithm>
#include <cctype>

#include "planish/core/error.h"

namespace planish::command {
namespace {

bool is_vulkan(const ListedDevice& device) { return device.selector != "cpu"; }

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string selectors(const std::vector<ListedDevice>& devices) {
  std::string text;
  for (const ListedDevice& device : devices) {
    text += (text.empty() ? "" : ", ") + device.selector + " (" + device.description.name + ")";
  }
  return text;
}

// Exactly by index or UUID, else by a part of the name, any case, that only one device has.
std::size_t find_named(const std::vector<ListedDevice>& devices, const std::string& wanted) {
  std::vector<std::size_t> matches;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceDescription& description = devices[i].description;
    if (devices[i].selector == wanted) return i;
    if (!description.uuid.empty() && lower(description.uuid) == lower(wanted)) return i;
    if (lower(description.name) == lower(wanted)) return i;
    if (lower(description.name).find(lower(wanted)) != std::string::npos) matches.push_back(i);
  }
  if (matches.size() == 1) return matches.front();
  throw Error(ErrorCode::NoDevice, "--device " + wanted +
                                       (matches.empty() ? " names none of the devices: "
                                                        : " names several of the devices: ") +
                                       selectors(devices));
}

std::size_t best_vulkan(const std::vector<ListedDevice>& devices) {
  std::size_t best = devices.size();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!is_vulkan(devices[i]) || !devices[i].unusable_because.empty()) continue;
    const bool hardware = devices[i].description.kind != "software";
    if (best == devices.size() || (hardware && devices[best].description.kind == "software")) {
      best = i;
    }
  }
  return best;
}

}  // namespace

std::vector<ListedDevice> list_devices() {
  std::vector<ListedDevice> devices;
  devices.push_back({"cpu", make_cpu_backend()->description(), {}, ""});
  return devices;
}

std::string why_no_vulkan(const std::vector<ListedDevice>& devices) {
  for (const ListedDevice& device : devices) {
    if (is_vulkan(device) && device.unusable_because.empty()) return "";
  }
  for (const ListedDevice& device : devices) {
    if (is_vulkan(device)) return device.description.name + ": " + device.unusable_because;
  }
  return "this planish was built without Vulkan (PLANISH_VULKAN=OFF)";
}

std::size_t automatic_choice(const std::vector<ListedDevice>& devices, const Settings& settings) {
  const auto cpu = std::ranges::find(devices, "cpu", &ListedDevice::selector);
  const auto cpu_position = static_cast<std::size_t>(cpu - devices.begin());
  // What only the CPU can do leaves no choice; nor does a Vulkan device that is the CPU itself.
  if (settings.precision != PrecisionChoice::Auto || solve_precision(settings) == Precision::Double)
    return cpu_position;
  const std::size_t best = best_vulkan(devices);
  const bool hardware = best < devices.size() && devices[best].description.kind != "software";
  return hardware ? best : cpu_position;
}

std::size_t choose_device(const std::vector<ListedDevice>& devices, const Settings& settings) {
  if (settings.device == "auto") return automatic_choice(devices, settings);
  std::size_t chosen = 0;
  if (settings.device == "vulkan") {
    chosen = best_vulkan(devices);
    if (chosen == devices.size()) {
      throw Error(ErrorCode::NoDevice, "--device vulkan: " + why_no_vulkan(devices));
    }
  } else {
    chosen = find_named(devices, settings.device);
  }
  const ListedDevice& device = devices[chosen];
  if (!device.unusable_because.empty()) {
    throw Error(ErrorCode::NoDevice, device.description.name + ": " + device.unusable_because);
  }
  if (is_vulkan(device) && settings.precision != PrecisionChoice::Auto) {
    throw Error(ErrorCode::InvalidArgument,
                "--precision is for the CPU backend; leave it out with --device " +
                    settings.device + ", or take --device cpu");
  }
  return chosen;
}

std::unique_ptr<Backend> open_backend(const ListedDevice&, const Settings& settings) {
  return make_cpu_backend({.solve_precision = solve_precision(settings)});
}

}  // namespace planish::command
