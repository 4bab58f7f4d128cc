// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace waymark::mapping {

/// A real Slurm of our own on loopback, with two nodes: authentication, controller and node daemons
/// run as the user who runs the test and end with it.
class SlurmCluster {
 public:
  /// Whether this machine has Slurm's programs.
  static bool IsInstalled();

  /// Starts the daemons and waits until both nodes are idle; SLURM_CONF points at them until
  /// destruction. `folder` is made; its path must be short enough for a socket.
  explicit SlurmCluster(std::filesystem::path folder, int cpus_of_node = 1);
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// Whether both nodes answered; if not, logs are in the folder.
  bool is_ready() const { return is_ready_; }

  /// A node that runs a job now, "" when none does.
  std::string FindBusyNode() const;

  /// The power of a node fails: its daemon and everything it runs end at once.
  void KillNode(const std::string& node);

 private:
  void WriteConfiguration() const;
  void Start(const std::string& name, const std::vector<std::string>& words);

  std::filesystem::path folder_;
  int cpus_of_node_;
  std::map<std::string, pid_t> daemons_;
  bool is_ready_ = false;
};

}  // namespace waymark::mapping
