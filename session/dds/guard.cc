// SPDX-License-Identifier: Apache-2.0
#include "session/dds/guard.h"

#include <utility>

#include "session/dds/internal/access_control.h"

namespace waymark::session::dds {

Guard::Guard(IdentityOf identity_of)
    : access_control_(std::make_shared<internal::AccessControl>(std::move(identity_of))) {}
Guard::~Guard() = default;

void Guard::Refuse(std::set<std::string> names) { access_control_->Refuse(std::move(names)); }
std::set<std::string> Guard::PutOut() { return access_control_->PutOut(); }
void Guard::TellOfStrangers() {
  access_control_->strangers().Tell(std::chrono::steady_clock::now());
}

}  // namespace waymark::session::dds
