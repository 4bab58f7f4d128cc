// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "mapping/base/result.h"
#include "session/dds/participant.h"

namespace waymark::session::dds {

enum class Delivery { kBestEffort, kReliable };
enum class History { kNone, kForLateJoiners };  ///< transient-local, as long as the writer lives

/// A topic with the quality of service of its endpoints. Always keep-last: a writer then never
/// waits for a slow or dead reader, and nobody can make a reader's memory grow.
struct Topic {
  std::string name;
  const void* descriptor = nullptr;  ///< the generated <type>_desc
  Delivery delivery = Delivery::kReliable;
  History history = History::kNone;
  int depth = 1;  ///< samples kept per key, >= 1
};

/// Writes samples of the topic's generated type. Thread-safe. Instances survive the writer: a
/// crashed process disposes nothing.
class Writer {
 public:
  static Result<Writer> Create(Participant& participant, const Topic& topic,
                               const std::string& partition);

  Result<void> Write(const void* sample);
  /// The instance is over; readers learn it. `Forget` later frees what late joiners would see of
  /// it.
  Result<void> Dispose(const void* sample);
  void Forget(const void* sample);
  /// Waits until every matched reader has what was written, or the time is over.
  bool WaitForAcknowledgements(std::chrono::milliseconds patience);
  /// Whether anybody hears what is written.
  bool HasReaders() const;

 private:
  Writer(Entity publisher, Entity writer, std::string name, const void* kept_type)
      : publisher_(std::move(publisher)),
        writer_(std::move(writer)),
        name_(std::move(name)),
        kept_type_(kept_type) {}

  Entity publisher_;
  Entity writer_;
  std::string name_;
  const void* kept_type_;  // of samples that stay for late joiners; null: none stays
};

/// What happened to an instance of a topic.
enum class Arrival {
  kSample,    ///< a value; the sample is whole
  kDisposed,  ///< its writer ended it; only the key is set
  kLost,      ///< no writer is left; only the key is set
};

/// Who wrote a sample, as far as DDS tells.
class Source {
 public:
  Source(std::int32_t reader, std::uint64_t publication,
         std::map<std::uint64_t, std::string>& known)
      : reader_(reader), publication_(publication), known_(known) {}

  /// Where its writer writes; empty when that is gone and was not asked for before.
  std::string Partition() const;

 private:
  std::int32_t reader_;
  std::uint64_t publication_;
  std::map<std::uint64_t, std::string>& known_;
};

/// Hands every arrival to a handler on a DDS thread. The handler must be quick and only enqueue;
/// it is never called after the reader is destroyed.
class Reader {
 public:
  using Handler = std::function<void(Arrival arrival, const void* sample, const Source& source)>;

  /// `partition` may hold wildcards.
  static Result<Reader> Create(Participant& participant, const Topic& topic,
                               const std::string& partition, Handler handler);

 private:
  struct Listening;

  Reader(std::unique_ptr<Listening> listening, Entity subscriber, Entity reader);

 public:
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();

 private:
  std::unique_ptr<Listening> listening_;  // outlives reader_, whose deletion waits for the handler
  Entity subscriber_;
  Entity reader_;
};

}  // namespace waymark::session::dds
