#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "map/map_store.h"
#include "map/paging.h"

namespace hgg {

/// Keeps a map store for a mapper: takes what is paged out, gives it back, and writes the map's changes now and then.
/// Everything that touches the disk is done by two threads of its own, one that writes and one that reads, so that a
/// slow disk delays no frame.
class PageKeeper {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Patience : std::uint8_t {
    kWaits,   // for a page that is asked for, and for the disk when too much waits for it: the same log, the same map
    kPrompt,  // a page that does not come within some milliseconds is asked for again at the next frame
  };
  /// The file is made when it is first needed. `journal_s`: the map's changes are to be written this often, s, and what
  /// is written outlives a power cut; 0: nothing is kept beyond this object.
  PageKeeper(std::string path, double budget_mb, double journal_s, Patience patience);
  /// Waits for what is being written. Removes the file if it is scratch or discarded.
  ~PageKeeper();
  PageKeeper(const PageKeeper&) = delete;
  PageKeeper& operator=(const PageKeeper&) = delete;

  /// The door to it, which must not outlive it.
  PageStore store();

  /// Whether changes are to be handed over now. `now` goes up from call to call.
  bool isDue(Clock::time_point now);
  /// Whether all there is in memory is to be handed over, and not the changes since last time alone: at first, and
  /// after what was handed over could not be written.
  bool needsAll() const;
  /// Takes changes to be written in one go with what has been paged out. Call it when it is due.
  void write(MapChanges changes);
  /// Waits until all that was handed over is written. Why that failed; empty when it did not.
  std::string settle();
  /// From now on pages are waited for, however long that takes: at the end of a run.
  void beginToSave() { patience_ = Patience::kWaits; }
  /// All of it is safe elsewhere.
  void discard() { is_discarded_ = true; }
  /// Seconds since all of the map was last safe on disk; nullopt: never.
  std::optional<double> savedAge(Clock::time_point now) const;
  /// What is wrong, a line; empty: nothing.
  std::string trouble() const;

  /// A page as it is, which stays where it is. The error: it cannot be read, or not in time.
  Result<MapPage> read(KeyframeId id);

 private:
  using SharedPage = std::shared_ptr<const MapPage>;
  struct Job {
    std::optional<MapChanges> changes;
    std::vector<SharedPage> pages;
    Clock::time_point as_of;
  };

  void put(MapPage page);
  TakenPage take(KeyframeId id);
  void prefetch(const std::vector<KeyframeId>& ids);
  bool hasRoom();
  /// Waits until a page that is on disk was read, as long as a frame may; false: not in time.
  bool awaitRead(std::unique_lock<std::mutex>& lock, KeyframeId id);
  double megabytes() const;

  bool isJournal() const { return journal_s_ > 0; }
  void writeJobs(const std::stop_token& stop);
  /// What is to be written next; nullopt: nothing.
  std::optional<Job> nextJob();
  std::string carryOut(const Job& job);
  void readPages(const std::stop_token& stop);
  std::optional<KeyframeId> nextToRead() const;

  std::string path_;
  double budget_mb_, journal_s_;
  Patience patience_;
  bool is_discarded_ = false;
  std::optional<MapStore> writer_, reader_;  // of the thread that uses it

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any to_write_, to_read_, done_;
  std::map<KeyframeId, SharedPage> pending_;     // put, and not written yet
  std::map<KeyframeId, Result<MapPage>> ready_;  // read ahead
  std::set<KeyframeId> wanted_;                  // to be read ahead
  std::optional<KeyframeId> urgent_;             // to be read now
  std::optional<KeyframeId> reading_;            // being read; nullopt once that is of no use any more
  std::optional<MapChanges> changes_;            // handed over
  double pending_mb_ = 0, ready_mb_ = 0;
  bool is_writing_ = false, is_flushed_ = false, needs_all_ = true;
  std::string error_;  // of the last try to write
  std::int64_t lost_ = 0;
  Clock::time_point due_{}, retry_{}, slow_until_{};  // slow: the disk, and waiting for it is no use
  std::optional<Clock::time_point> saved_;
  std::jthread writing_, reading_thread_;  // last: joined before anything above goes
};

}  // namespace hgg
