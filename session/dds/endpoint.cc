// SPDX-License-Identifier: Apache-2.0
#include "session/dds/endpoint.h"

#include <dds/dds.h>

#include <array>
#include <exception>

#include "mapping/base/log.h"
#include "session/dds/internal/kept_sample.h"
#include "session/dds/internal/qos.h"

namespace waymark::session::dds {
namespace {

using internal::Qos;

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};

Qos PartitionQos(const std::string& partition) {
  Qos qos(dds_create_qos());
  dds_qset_partition1(qos.get(), partition.c_str());
  return qos;
}

Qos EndpointQos(const Topic& topic) {
  Qos qos(dds_create_qos());
  // Writing never waits: with keep-last there is nothing to wait for below the high watermark.
  dds_qset_reliability(qos.get(),
                       topic.delivery == Delivery::kReliable ? DDS_RELIABILITY_RELIABLE
                                                             : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(10));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.depth);
  if (topic.history == History::kForLateJoiners) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

Result<void> CheckCode(dds_return_t code, const std::string& object) {
  if (code < 0) return ErrorFromCode(code, object);
  return {};
}

/// Samples lent by a reader; given back on destruction.
class Loan {
 public:
  explicit Loan(dds_entity_t reader)
      : reader_(reader),
        count_(dds_take(reader, samples_.data(), infos_.data(), samples_.size(),
                        static_cast<std::uint32_t>(samples_.size()))) {}
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;
  ~Loan() {
    if (count_ > 0) (void)dds_return_loan(reader_, samples_.data(), count_);
  }

  std::size_t size() const { return count_ < 0 ? 0 : static_cast<std::size_t>(count_); }
  bool IsFull() const { return size() == samples_.size(); }
  const void* sample(std::size_t i) const { return samples_[i]; }
  std::uint64_t publication(std::size_t i) const { return infos_[i].publication_handle; }

  Arrival arrival(std::size_t i) const {
    if (infos_[i].valid_data) return Arrival::kSample;
    return infos_[i].instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE ? Arrival::kDisposed
                                                                             : Arrival::kLost;
  }
  /// The last value and the end of an instance may come as one sample.
  bool IsAlsoDisposed(std::size_t i) const {
    return infos_[i].valid_data &&
           infos_[i].instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE;
  }

 private:
  dds_entity_t reader_;
  std::array<void*, 32> samples_{};
  std::array<dds_sample_info_t, 32> infos_;
  dds_return_t count_;
};

}  // namespace

// ---- Writer -----------------------------------------------------------------------------------

Result<Writer> Writer::Create(Participant& participant, const Topic& topic,
                              const std::string& partition) {
  WAYMARK_TRY_ASSIGN(const std::int32_t topic_handle,
                     participant.FindOrCreateTopic(topic.name, topic.descriptor));
  const Qos partition_qos = PartitionQos(partition);
  WAYMARK_TRY_ASSIGN(
      Entity publisher,
      Entity::Adopt(dds_create_publisher(participant.handle(), partition_qos.get(), nullptr),
                    topic.name));
  const Qos qos = EndpointQos(topic);
  WAYMARK_TRY_ASSIGN(
      Entity writer,
      Entity::Adopt(dds_create_writer(publisher.handle(), topic_handle, qos.get(), nullptr),
                    topic.name));
  const void* const kept = topic.history == History::kForLateJoiners ? topic.descriptor : nullptr;
  return Writer(std::move(publisher), std::move(writer), topic.name, kept);
}

Result<void> Writer::Write(const void* sample) {
  if (kept_type_ != nullptr) {
    const auto& type = *static_cast<const dds_topic_descriptor_t*>(kept_type_);
    return CheckCode(internal::WriteKept(writer_.handle(), type, sample), name_);
  }
  return CheckCode(dds_write(writer_.handle(), sample), name_);
}

Result<void> Writer::Dispose(const void* sample) {
  return CheckCode(dds_dispose(writer_.handle(), sample), name_);
}

void Writer::Forget(const void* sample) {
  (void)dds_unregister_instance(writer_.handle(), sample);  // already forgotten is as good
}

bool Writer::WaitForAcknowledgements(std::chrono::milliseconds patience) {
  return dds_wait_for_acks(writer_.handle(), DDS_MSECS(patience.count())) == DDS_RETCODE_OK;
}

bool Writer::HasReaders() const {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer_.handle(), &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}

// ---- Reader -----------------------------------------------------------------------------------

std::string Source::Partition() const {
  constexpr std::size_t kMaxKnown = 8192;
  if (const auto found = known_.find(publication_); found != known_.end()) return found->second;
  dds_builtintopic_endpoint_t* const endpoint =
      dds_get_matched_publication_data(reader_, publication_);
  if (endpoint == nullptr) return "";
  std::string partition;
  std::uint32_t count = 0;
  char** names = nullptr;
  if (dds_qget_partition(endpoint->qos, &count, &names)) {
    if (count == 1) partition = names[0];
    for (std::uint32_t i = 0; i < count; ++i) dds_free(names[i]);
    dds_free(names);
  }
  dds_builtintopic_free_endpoint(endpoint);
  if (known_.size() >= kMaxKnown) known_.clear();
  known_.emplace(publication_, partition);
  return partition;
}

struct Reader::Listening {
  Handler handler;
  std::map<std::uint64_t, std::string> known = {};  // partitions of writers; one thread uses it

  void Drain(dds_entity_t reader) {
    for (bool may_have_more = true; may_have_more;) {
      const Loan loan(reader);
      for (std::size_t i = 0; i < loan.size(); ++i) {
        const Source source(reader, loan.publication(i), known);
        handler(loan.arrival(i), loan.sample(i), source);
        if (loan.IsAlsoDisposed(i)) handler(Arrival::kDisposed, loan.sample(i), source);
      }
      may_have_more = loan.IsFull();
    }
  }

  static void OnDataAvailable(dds_entity_t reader, void* self) noexcept {
    try {
      static_cast<Listening*>(self)->Drain(reader);
    } catch (const std::exception& exception) {
      LogError("a sample was dropped: {}", exception.what());
    }
  }
};

Reader::Reader(std::unique_ptr<Listening> listening, Entity subscriber, Entity reader)
    : listening_(std::move(listening)),
      subscriber_(std::move(subscriber)),
      reader_(std::move(reader)) {}

Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

Reader::~Reader() { reader_.Reset(); }

Result<Reader> Reader::Create(Participant& participant, const Topic& topic,
                              const std::string& partition, Handler handler) {
  auto listening = std::make_unique<Listening>(Listening{std::move(handler)});
  WAYMARK_TRY_ASSIGN(const std::int32_t topic_handle,
                     participant.FindOrCreateTopic(topic.name, topic.descriptor));
  const Qos partition_qos = PartitionQos(partition);
  WAYMARK_TRY_ASSIGN(
      Entity subscriber,
      Entity::Adopt(dds_create_subscriber(participant.handle(), partition_qos.get(), nullptr),
                    topic.name));
  const std::unique_ptr<dds_listener_t, ListenerDeleter> listener(
      dds_create_listener(listening.get()));
  dds_lset_data_available(listener.get(), &Listening::OnDataAvailable);
  const Qos qos = EndpointQos(topic);
  WAYMARK_TRY_ASSIGN(
      Entity reader,
      Entity::Adopt(dds_create_reader(subscriber.handle(), topic_handle, qos.get(), listener.get()),
                    topic.name));
  return Reader(std::move(listening), std::move(subscriber), std::move(reader));
}

}  // namespace waymark::session::dds
