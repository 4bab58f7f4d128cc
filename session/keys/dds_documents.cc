// SPDX-License-Identifier: Apache-2.0
#include "session/keys/dds_documents.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>

namespace waymark::session::keys {
namespace {

// This Cyclone compares the number that a domain has within the process, see session/dds.
constexpr const char* kDomains =
    "<domains><id_range><min>0</min><max>230</max></id_range></domains>";

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string TimeText(WallTime time) { return fmt::format("{:%Y-%m-%dT%H:%M:%S}", time); }

/// Each partition by itself, so that no topic is allowed in another's.
std::string Criteria(const char* what, const std::vector<std::string>& partitions) {
  std::string xml;
  for (const std::string& partition : partitions) {
    xml += fmt::format(
        "    <{0}><topics><topic>waymark/*</topic></topics>"
        "<partitions><partition>{1}</partition></partitions></{0}>\n",
        what, Escape(partition));
  }
  return xml;
}

}  // namespace

std::string GovernanceXml() {
  return fmt::format(R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules><domain_rule>
    {}
    <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
    <enable_join_access_control>true</enable_join_access_control>
    <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
    <liveliness_protection_kind>SIGN</liveliness_protection_kind>
    <rtps_protection_kind>NONE</rtps_protection_kind>
    <topic_access_rules><topic_rule>
      <topic_expression>*</topic_expression>
      <enable_discovery_protection>true</enable_discovery_protection>
      <enable_liveliness_protection>true</enable_liveliness_protection>
      <enable_read_access_control>true</enable_read_access_control>
      <enable_write_access_control>true</enable_write_access_control>
      <metadata_protection_kind>NONE</metadata_protection_kind>
      <data_protection_kind>ENCRYPT</data_protection_kind>
    </topic_rule></topic_access_rules>
  </domain_rule></domain_access_rules>
</dds>
)",
                     kDomains);
}

std::string PermissionsXml(const Grant& grant) {
  return fmt::format(R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions><grant name="waymark">
    <subject_name>{}</subject_name>
    <validity><not_before>{}</not_before><not_after>{}</not_after></validity>
    <allow_rule>{}
{}{}    </allow_rule>
    <default>DENY</default>
  </grant></permissions>
</dds>
)",
                     Escape(grant.subject), TimeText(grant.validity.from),
                     TimeText(grant.validity.until), kDomains, Criteria("publish", grant.writes),
                     Criteria("subscribe", grant.reads));
}

std::optional<WallTime> FindPermissionsEnd(std::string_view text) {
  constexpr std::string_view kTag = "<not_after>";
  const std::size_t at = text.find(kTag);
  if (at == std::string_view::npos) return std::nullopt;
  std::tm end{};
  const std::string stamp(text.substr(at + kTag.size(), 19));
  const char* const rest = ::strptime(stamp.c_str(), "%Y-%m-%dT%H:%M:%S", &end);
  if (rest == nullptr || *rest != '\0') return std::nullopt;
  return WallTime(std::chrono::seconds(::timegm(&end)));
}

}  // namespace waymark::session::keys
