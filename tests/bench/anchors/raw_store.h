// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "content_store/anchor_record.h"

namespace waymark::bench {

/// How much a store by hand keeps.
enum class Facts {
  /// A durable row per anchor, found by id and by place, and nothing else.
  kRow,
  /// What the anchor store keeps: besides, a clash of ids is noticed, and every anchor is found by
  /// time of change and expiry, has its revision of one counter and a row in a log that can be read
  /// by room, counts in what its owner has, and is announced to others (PostgreSQL). Left out is
  /// what costs no statement (checksums, fingerprints, validation), and the log does not keep old
  /// states, so every payload is written once, as the store does.
  kSame,
};

/// What one would write by hand in the fastest way that plain SQL has: prepared statements, and for
/// PostgreSQL one statement a group, with binary arrays.
class RawStore {
 public:
  virtual ~RawStore() = default;

  /// One transaction, durable. Thread-compatible.
  virtual void Create(std::span<const content::AnchorRecord> records) = 0;
  virtual std::uint64_t Count() = 0;
};

/// What an earlier run left there is kept.
std::unique_ptr<RawStore> OpenRawSqlite(const std::string& file, Facts facts);
std::unique_ptr<RawStore> OpenRawPostgres(const std::string& uri, Facts facts);

}  // namespace waymark::bench
