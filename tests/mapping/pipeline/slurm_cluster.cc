// SPDX-License-Identifier: Apache-2.0
#include "tests/mapping/pipeline/slurm_cluster.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/base/process.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

constexpr std::array kNodes{"n1", "n2"};

fs::path FindProgram(const std::string& name) {
  for (const char* folder : {"/usr/sbin", "/usr/bin"}) {
    const fs::path path = fs::path(folder) / name;
    if (fs::exists(path)) return path;
  }
  return {};
}

/// Asks until the answer is yes or time is up.
template <typename Question>
bool Await(std::chrono::seconds limit, Question question) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!question()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

/// Processes whose environment holds NAME=VALUE.
std::vector<pid_t> FindProcesses(const std::string& setting) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (!std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c); })) continue;
    const int file = ::open((entry.path() / "environ").c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) continue;
    std::string text(1 << 16, '\0');
    const ssize_t size = ::read(file, text.data(), text.size());
    ::close(file);
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    const std::string whole = '\0' + setting + '\0';
    if (('\0' + text).find(whole) != std::string::npos) found.push_back(std::stoi(name));
  }
  return found;
}

/// The first line of a file below /proc, whose size nobody knows.
std::string ReadLine(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

pid_t ParentOf(pid_t process) {
  const std::string status = ReadLine(fmt::format("/proc/{}/stat", process));
  const std::size_t name_end = status.rfind(") ");  // "… (name) S PARENT …"
  return name_end == std::string::npos ? 0 : std::atoi(status.c_str() + name_end + 4);
}

}  // namespace

bool SlurmCluster::IsInstalled() {
  return std::ranges::all_of(std::array{"munged", "slurmctld", "slurmd", "sbatch", "squeue"},
                             [](const char* name) { return !FindProgram(name).empty(); });
}

SlurmCluster::SlurmCluster(fs::path folder, int cpus_of_node)
    : folder_(std::move(folder)), cpus_of_node_(cpus_of_node) {
  for (const char* name : {"state", "log", "run", "munge", "spool.n1", "spool.n2"}) {
    fs::create_directories(folder_ / name);
  }
  fs::permissions(folder_ / "munge", fs::perms::owner_all);
  std::string key(1024, '\0');
  std::random_device random;
  std::ranges::generate(key, [&] { return static_cast<char>(random()); });
  (void)StoreFileAtomically(folder_ / "munge/key", std::string_view(key));
  fs::permissions(folder_ / "munge/key", fs::perms::owner_read | fs::perms::owner_write);
  WriteConfiguration();
  ::setenv("SLURM_CONF", (folder_ / "slurm.conf").c_str(), 1);

  const fs::path socket = folder_ / "run/munge.sock";
  Start("munged",
        {"--foreground", "--num-threads=2", "--key-file=" + (folder_ / "munge/key").string(),
         "--socket=" + socket.string(), "--pid-file=" + (folder_ / "run/munged.pid").string(),
         "--log-file=" + (folder_ / "log/munged.log").string(),
         "--seed-file=" + (folder_ / "munge/seed").string()});
  Await(std::chrono::seconds(10), [&] { return fs::exists(socket); });
  Start("slurmctld", {"-D", "-i"});
  for (const char* node : kNodes) Start("slurmd", {"-D", "-N", node});
  is_ready_ = Await(std::chrono::seconds(30), [] {
    const auto idle = CaptureProgram({"sinfo", "-h", "-N", "-t", "idle", "-o", "%N"});
    return idle && idle->status == 0 && idle->output == "n1\nn2\n";
  });
}

SlurmCluster::~SlurmCluster() {
  for (const char* node : kNodes) KillNode(node);
  for (const auto& [name, process] : daemons_) ::kill(process, SIGKILL);
  for (const auto& [name, process] : daemons_) ::waitpid(process, nullptr, 0);
  ::unsetenv("SLURM_CONF");
  std::error_code ignored;
  if (is_ready_) fs::remove_all(folder_, ignored);
}

void SlurmCluster::WriteConfiguration() const {
  const std::string user = ::getpwuid(::geteuid())->pw_name;
  const int port = 20000 + ::getpid() % 10000;
  std::string text = fmt::format(
      "ClusterName=waymark\nSlurmctldHost=localhost(127.0.0.1)\nSlurmUser={1}\nSlurmdUser={1}\n"
      "AuthType=auth/munge\nAuthInfo=socket={0}/run/munge.sock,cred_expire=5\nCredType=cred/munge\n"
      "SlurmctldPort={2}\nCommunicationParameters=NoCtldInAddrAny,NoInAddrAny\n"
      "StateSaveLocation={0}/state\nSlurmdSpoolDir={0}/spool.%n\n"
      "SlurmctldPidFile={0}/run/slurmctld.pid\nSlurmdPidFile={0}/run/slurmd.%n.pid\n"
      "SlurmctldLogFile={0}/log/slurmctld.log\nSlurmdLogFile={0}/log/slurmd.%n.log\n"
      "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n"
      "JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n"
      "MpiDefault=none\nSwitchType=switch/none\nSelectType=select/cons_tres\n"
      "SelectTypeParameters=CR_CPU\nSchedulerType=sched/backfill\n"
      "SchedulerParameters=batch_sched_delay=1,sched_interval=5,bf_interval=5\n"
      "ReturnToService=2\nJobRequeue=1\nSlurmdTimeout=5\nSlurmctldTimeout=10\nKillWait=2\n"
      "MinJobAge=600\nSlurmdParameters=config_overrides\n",
      folder_.string(), user, port);
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    text += fmt::format(
        "NodeName={} NodeHostname=localhost NodeAddr=127.0.0.1 Port={} CPUs={} RealMemory=2000 "
        "State=UNKNOWN\n",
        kNodes[i], port + 1 + static_cast<int>(i), cpus_of_node_);
  }
  text += "PartitionName=main Nodes=n[1-2] Default=YES MaxTime=INFINITE State=UP\n";
  (void)StoreFileAtomically(folder_ / "slurm.conf", std::string_view(text));
}

void SlurmCluster::Start(const std::string& name, const std::vector<std::string>& words) {
  const std::string program = FindProgram(name).string();
  const std::string key = words.size() > 2 && words[1] == "-N" ? words[2] : name;
  const std::string log = (folder_ / "log" / (key + ".out")).string();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // whatever becomes of the test
    const int output = ::open(log.c_str(), O_WRONLY | O_CREAT, 0644);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  daemons_[key] = child;
}

std::string SlurmCluster::FindBusyNode() const {
  for (const char* node : kNodes) {
    if (!FindProcesses(fmt::format("SLURMD_NODENAME={}", node)).empty()) return node;
  }
  return {};
}

void SlurmCluster::KillNode(const std::string& node) {
  const auto daemon = daemons_.find(node);
  if (daemon == daemons_.end()) return;
  ::kill(daemon->second, SIGKILL);
  ::waitpid(daemon->second, nullptr, 0);
  daemons_.erase(daemon);
  for (const pid_t job : FindProcesses("SLURMD_NODENAME=" + node)) {
    const pid_t parent = ParentOf(job);
    const std::string name = ReadLine(fmt::format("/proc/{}/comm", parent));
    if (name.starts_with("slurmstepd")) ::kill(parent, SIGKILL);
    ::kill(job, SIGKILL);
  }
}

}  // namespace waymark::mapping
