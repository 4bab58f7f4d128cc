// SPDX-License-Identifier: Apache-2.0
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "session/dds/internal/kept_sample.h"

namespace waymark::session::dds::internal {
namespace {

using Bytes = std::vector<unsigned char>;

/// The sample with the four octets before it that say how it is encoded.
Bytes Serialise(const dds_topic_descriptor_t& type, const void* sample) {
  constexpr unsigned char kFinal = 7, kAppendable = 9;  // XCDR version 2, little-endian
  constexpr std::size_t kAlignment = 4;
  dds_ostreamLE_t stream;
  dds_ostreamLE_init(&stream, 0, CDR_ENC_VERSION_2);
  (void)dds_stream_writeLE(&stream, static_cast<const char*>(sample), type.m_ops);
  const std::size_t padding = (kAlignment - stream.x.m_index % kAlignment) % kAlignment;
  Bytes bytes;
  bytes.reserve(4 + stream.x.m_index + padding);
  bytes = {0, DDS_OP(type.m_ops[0]) == DDS_OP_DLC ? kAppendable : kFinal, 0,
           static_cast<unsigned char>(padding)};
  bytes.insert(bytes.end(), stream.x.m_buffer, stream.x.m_buffer + stream.x.m_index);
  bytes.insert(bytes.end(), padding, 0);
  dds_ostreamLE_fini(&stream);
  return bytes;
}

/// Bytes of a type that is no writer's own. A writer takes them as it takes what a bridge between
/// domains hands on: it checks them and copies them into a sample of its type, of that size.
struct Foreign : ddsi_serdata {
  Foreign(const ddsi_sertype& of_type, Bytes of) : ddsi_serdata{}, bytes(std::move(of)) {
    ddsi_serdata_init(this, &of_type, SDK_DATA);
  }

  static const Foreign& From(const ddsi_serdata* data) {
    return *static_cast<const Foreign*>(data);
  }
  static std::uint32_t SizeOf(const ddsi_serdata* data) {
    return static_cast<std::uint32_t>(From(data).bytes.size());
  }
  static void CopyTo(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* to) {
    std::memcpy(to, From(data).bytes.data() + offset, size);
  }
  static ddsi_serdata* Lend(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                            ddsrt_iovec_t* lent) {
    lent->iov_base = const_cast<unsigned char*>(From(data).bytes.data()) + offset;
    lent->iov_len = size;
    return ddsi_serdata_ref(data);
  }
  static void TakeBack(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }
  static void Delete(ddsi_serdata* data) { delete static_cast<Foreign*>(data); }

  Bytes bytes;
};

const ddsi_sertype& ForeignType() {
  static const ddsi_serdata_ops data_ops = [] {
    ddsi_serdata_ops ops{};
    ops.get_size = Foreign::SizeOf;
    ops.to_ser = Foreign::CopyTo;
    ops.to_ser_ref = Foreign::Lend;
    ops.to_ser_unref = Foreign::TakeBack;
    ops.free = Foreign::Delete;
    return ops;
  }();
  static const ddsi_sertype_ops type_ops = [] {
    ddsi_sertype_ops ops{};
    ops.version = ddsi_sertype_v0;
    return ops;
  }();
  static const ddsi_sertype type = [] {
    ddsi_sertype made{};
    made.ops = &type_ops;
    made.serdata_ops = &data_ops;
    return made;
  }();
  return type;
}

}  // namespace

dds_return_t WriteKept(dds_entity_t writer, const dds_topic_descriptor_t& type,
                       const void* sample) {
  return dds_writecdr(writer, new Foreign(ForeignType(), Serialise(type, sample)));  // frees it
}

}  // namespace waymark::session::dds::internal
