// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

namespace waymark::session::dds::internal {

/// As dds_write, for what a writer keeps: in memory of its own size. What dds_write serialises
/// stays in blocks of 4 KiB, which for an anchor of 600 octets was half of all that a server held.
dds_return_t WriteKept(dds_entity_t writer, const dds_topic_descriptor_t& type, const void* sample);

}  // namespace waymark::session::dds::internal
