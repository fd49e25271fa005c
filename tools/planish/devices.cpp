#include "devices.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "commands.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"
#include "terminal.h"

#if PLANISH_HAS_VULKAN
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::command {
namespace {

bool is_vulkan(const ListedDevice& device) { return device.selector != "cpu"; }
bool is_usable(const ListedDevice& device) { return device.unusable_because.empty(); }
bool is_hardware(const ListedDevice& device) { return device.description.kind == "gpu"; }

std::string selectors(const std::vector<ListedDevice>& devices) {
  std::string text;
  for (const ListedDevice& device : devices) {
    text +=
        formatted("{}{} ({})", text.empty() ? "" : ", ", device.selector, device.description.name);
  }
  return text;
}

#if PLANISH_HAS_VULKAN
void add_vulkan_devices(DeviceList& list) {
  const VulkanDeviceList found = list_vulkan_devices();
  list.no_vulkan_because = found.reason;
  for (std::size_t i = 0; i < found.devices.size(); ++i) {
    const VulkanDeviceInfo& device = found.devices[i];
    list.devices.push_back({std::to_string(i),
                            device.description,
                            {{"memory_bytes", device.memory_bytes},
                             {"max_storage_bytes", device.max_storage_bytes},
                             {"max_allocation_bytes", device.max_allocation_bytes},
                             {"max_work_groups", device.max_work_groups},
                             {"max_storage_buffers", device.max_storage_buffers}},
                            device.usable ? "" : device.reason,
                            device.portability_subset,
                            device.missing});
  }
  if (!list.devices.empty() && std::ranges::none_of(list.devices, is_usable)) {
    const ListedDevice& first = list.devices.front();
    list.no_vulkan_because = first.description.name + " " + first.unusable_because;
  }
}
#else
void add_vulkan_devices(DeviceList& list) {
  list.no_vulkan_because = "this planish was built without Vulkan (PLANISH_VULKAN=OFF)";
}
#endif

// A number is an index: as a part of a name it would match what nobody meant.
std::size_t find_index(const std::vector<ListedDevice>& devices, const std::string& number) {
  const auto found = std::ranges::find(devices, number, &ListedDevice::selector);
  if (found != devices.end()) return static_cast<std::size_t>(found - devices.begin());
  throw Error(ErrorCode::NoDevice,
              formatted("--device {}: there {}{}", number, devices.size() == 1 ? "is " : "are ",
                        selectors(devices)));
}

// Exactly by index, UUID or name, else by a part of the name that only one device has; any case.
std::size_t find_named(const std::vector<ListedDevice>& devices, const std::string& name) {
  const std::string wanted = lower_case(name);
  std::int64_t index = 0;
  if (parse_integer(name, index)) return find_index(devices, name);
  std::vector<std::size_t> matches;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceDescription& description = devices[i].description;
    if (devices[i].selector == wanted || lower_case(description.uuid) == wanted ||
        lower_case(description.name) == wanted) {
      return i;
    }
    if (lower_case(description.name).find(wanted) != std::string::npos) matches.push_back(i);
  }
  if (matches.size() == 1) return matches.front();
  throw Error(ErrorCode::NoDevice, "--device " + visible(name) +
                                       (matches.empty() ? " names none of the devices: "
                                                        : " names several of the devices: ") +
                                       selectors(devices));
}

bool is_cpu(const Settings& settings) {
  return settings.device == "auto" || settings.device == "cpu";
}

}  // namespace

DeviceList list_devices(DeviceScope scope) {
  DeviceList list;
  if (scope == DeviceScope::All) add_vulkan_devices(list);
  list.devices.push_back({"cpu", make_cpu_backend()->description(), {}, ""});
  return list;
}

DeviceScope scope_of(const Settings& settings) {
  return is_cpu(settings) ? DeviceScope::CpuOnly : DeviceScope::All;
}

std::size_t best_vulkan(const DeviceList& list) {
  const std::vector<ListedDevice>& devices = list.devices;
  std::size_t best = devices.size();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!is_vulkan(devices[i]) || !is_usable(devices[i])) continue;
    const bool better =
        best == devices.size() || (is_hardware(devices[i]) && !is_hardware(devices[best]));
    if (better) best = i;
  }
  return best;
}

std::size_t choose_device(const DeviceList& list, const Settings& settings) {
  const std::vector<ListedDevice>& devices = list.devices;
  if (is_cpu(settings)) return devices.size() - 1;
  std::size_t chosen = 0;
  if (settings.device == "vulkan") {
    chosen = best_vulkan(list);
    if (chosen == devices.size()) {
      throw Error(ErrorCode::NoDevice, "--device vulkan: " + list.no_vulkan_because);
    }
  } else {
    chosen = find_named(devices, settings.device);
  }
  const ListedDevice& device = devices[chosen];
  if (!is_usable(device)) {
    throw Error(ErrorCode::NoDevice, device.description.name + " " + device.unusable_because);
  }
  if (is_vulkan(device) && settings.precision != PrecisionChoice::Auto) {
    throw Error(ErrorCode::InvalidArgument,
                "--precision is for the CPU backend; leave it out with --device " +
                    settings.device + ", or take --device cpu");
  }
  return chosen;
}

std::unique_ptr<Backend> open_backend(const ListedDevice& device, const Settings& settings) {
#if PLANISH_HAS_VULKAN
  if (is_vulkan(device)) return make_vulkan_backend({.device = device.selector});
#endif
  (void)device;
  return make_cpu_backend({.solve_precision = solve_precision(settings)});
}

namespace {

// "0: 30.9 GiB of memory, buffers to 128.0 MiB, ...": the names of the limits as words.
std::string limits_line(const ListedDevice& device) {
  std::string text = device.selector + ":";
  const char* separator = " ";
  for (const auto& [name, value] : device.limits) {
    constexpr std::string_view kBytes = "_bytes";
    const bool is_bytes = name.ends_with(kBytes);
    std::string words = is_bytes ? name.substr(0, name.size() - kBytes.size()) : name;
    std::ranges::replace(words, '_', ' ');
    text += separator + words + " " +
            (is_bytes ? byte_size(value) : with_separators(static_cast<std::int64_t>(value)));
    separator = ", ";
  }
  return text;
}

}  // namespace

std::string devices_json(const DeviceList& list) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.devices/1";
  json["auto"] = list.devices.back().selector;
  const std::size_t best = best_vulkan(list);
  if (best < list.devices.size()) json["vulkan"] = list.devices[best].selector;
  json["no_vulkan_because"] = list.no_vulkan_because;
  json["devices"] = nlohmann::ordered_json::array();
  for (const ListedDevice& device : list.devices) {
    nlohmann::ordered_json entry;
    entry["selector"] = device.selector;
    entry["kind"] = device.description.kind;
    entry["name"] = device.description.name;
    entry["uuid"] = device.description.uuid;
    entry["driver"] = device.description.driver;
    entry["api"] = device.description.api;
    entry["usable"] = device.unusable_because.empty();
    entry["unusable_because"] = device.unusable_because;
    entry["portability_subset"] = device.portability_subset;
    entry["missing"] = device.missing;
    entry["limits"] = nlohmann::ordered_json::object();
    for (const auto& [name, value] : device.limits) entry["limits"][name] = value;
    json["devices"].push_back(entry);
  }
  return json_text(json);
}

std::string devices_table(const DeviceList& list) {
  const std::vector<ListedDevice>& devices = list.devices;
  const std::size_t best = best_vulkan(list);
  Table table({{"--device"}, {"kind"}, {"name"}, {"driver"}, {"api"}, {"uuid"}, {""}});
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const ListedDevice& device = devices[i];
    const DeviceDescription& description = device.description;
    std::string remark = i == best ? "taken by vulkan" : "";
    if (i + 1 == devices.size()) remark = "taken by auto";
    if (!device.unusable_because.empty()) remark = "unusable: " + device.unusable_because;
    table.add_row({device.selector, description.kind, description.name, description.driver,
                   description.api, description.uuid, remark});
  }
  std::string text = table.text();
  for (const ListedDevice& device : devices) {
    if (!device.limits.empty()) text += limits_line(device) + "\n";
    if (device.portability_subset)
      text += device.selector + ": a layer over another API (VK_KHR_portability_subset)\n";
    for (const std::string& feature : device.missing)
      text += device.selector + ": lacks " + feature + "\n";
  }
  const std::string& reason = list.no_vulkan_because;
  return reason.empty() ? text : text + "no usable Vulkan device: " + reason + "\n";
}

void add_devices_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "devices", "compute devices, their limits, and which ones auto and vulkan take");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON, with all limits to the byte")->group("Flags");
  invocation.texts["devices"] = {
      .examples = {"planish devices", "planish devices --json"}, .first_flags = {}, .notes = ""};
  command->callback([json, &invocation] {
    invocation.action = [json] {
      const DeviceList list = list_devices(DeviceScope::All);
      if (*json) {
        write_stdout(devices_json(list));
      } else {
        write_text(devices_table(list));
      }
      return ExitCode::Done;
    };
  });
}

}  // namespace planish::command
