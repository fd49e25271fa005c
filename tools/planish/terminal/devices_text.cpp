#include "terminal/devices_text.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <algorithm>

#include "planish/core/json.h"
#include "planish/job/report_json.h"
#include "planish/job/text.h"
#include "terminal/table.h"

namespace planish::command {

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

}  // namespace planish::command
