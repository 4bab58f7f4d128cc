// SPDX-License-Identifier: Apache-2.0
#include "session/wire/gateway_line.h"

#include <mutex>
#include <optional>

#include "session/wire/internal/topics.h"

namespace waymark::session::wire {

struct GatewayLine::Impl {
  Impl(std::shared_ptr<dds::Participant> participant_in, dds::Writer writer_in, GatewayId gateway)
      : participant(std::move(participant_in)), writer(std::move(writer_in)) {
    gathered.gateway = gateway;
  }

  std::shared_ptr<dds::Participant> participant;
  dds::Writer writer;
  std::atomic<std::uint64_t> rejected = 0;
  std::mutex mutex;
  GatewayReport gathered;             // guarded by mutex
  std::optional<dds::Reader> reader;  // last: its callbacks end before the rest goes

  // With the mutex held. What is not sent is no loss: the next one is better.
  void Send() {
    if (gathered.poses.empty() && gathered.pings.empty()) return;
    (void)Write(writer, gathered);
    gathered.poses.clear();
    gathered.pings.clear();
  }

  template <typename Message>
  void Gather(const Message& message, std::vector<Message> GatewayReport::*of_kind) {
    const std::lock_guard lock(mutex);
    (gathered.*of_kind).push_back(message);
    if ((gathered.*of_kind).size() == kMaxPerGatewayReport) Send();
  }
};

GatewayLine::GatewayLine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GatewayLine::~GatewayLine() = default;

Result<std::unique_ptr<GatewayLine>> GatewayLine::Create(
    std::shared_ptr<dds::Participant> participant, GatewayId gateway, Handler handler) {
  WAYMARK_TRY_ASSIGN(auto writer, MakeWriter<GatewayReport>(*participant, kGatewaysUp));
  auto impl = std::make_unique<Impl>(participant, std::move(writer), gateway);
  WAYMARK_TRY_ASSIGN(impl->reader,
                     MakeReader<GatewayPongs>(*participant, kGatewaysDown, impl->rejected,
                                              [gateway, handler](const GatewayPongs& pongs) {
                                                if (pongs.gateway != gateway) return;
                                                for (const ClockPong& pong : pongs.pongs) {
                                                  handler(pong);
                                                }
                                              }));
  return std::unique_ptr<GatewayLine>(new GatewayLine(std::move(impl)));
}

void GatewayLine::Gather(const PoseReport& report) { impl_->Gather(report, &GatewayReport::poses); }
void GatewayLine::Gather(const ClockPing& ping) { impl_->Gather(ping, &GatewayReport::pings); }

void GatewayLine::Flush() {
  const std::lock_guard lock(impl_->mutex);
  impl_->Send();
}

}  // namespace waymark::session::wire
