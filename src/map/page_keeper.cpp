#include "map/page_keeper.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/signals.h"

namespace hgg {
namespace {

/// Mapping goes first where there are fewer cores than threads.
constexpr int kNice = 10;
/// Pages are written together, so many at a time, where no journal says when.
constexpr std::size_t kBatch = 32;
/// So much may wait to be written, as a share of the budget.
constexpr double kMostPendingShare = 0.1;
/// Pages that come back in one frame: a few milliseconds' work.
constexpr std::size_t kMostAtOnce = 8;
/// How long a prompt frame waits for a page, and how long after a failure writing is tried again.
constexpr std::chrono::milliseconds kPromptWait(2), kRetry(2000);
/// So long the disk is taken for slow after a page did not come in time.
constexpr std::chrono::milliseconds kSlow(100);

void giveWay() { ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice); }

double megabytesOf(const MapPage& page) {
  std::size_t leaves = 0;
  for (const MapNode& node : page.nodes) {
    leaves += leavesOf(node).size();
  }
  return Map::megabytesOf(page.nodes.size(), leaves);
}

}  // namespace

PageKeeper::PageKeeper(std::string path, double budget_mb, double journal_s, Patience patience)
    : path_(std::move(path)),
      budget_mb_(budget_mb),
      journal_s_(journal_s),
      patience_(patience),
      writing_([this](const std::stop_token& stop) { writeJobs(stop); }),
      reading_thread_([this](const std::stop_token& stop) { readPages(stop); }) {}

PageKeeper::~PageKeeper() {
  reading_thread_ = {};
  writing_ = {};
  writer_.reset(), reader_.reset();
  if (!isJournal() || is_discarded_) {
    removeMapStore(path_);
  }
}

PageStore PageKeeper::store() {
  PageStore store;
  store.put = [this](MapPage page) { put(std::move(page)); };
  store.take = [this](KeyframeId id) { return take(id); };
  store.keep_radius = 0;
  store.most_at_once = kMostAtOnce;
  store.budget_mb = budget_mb_;
  store.has_room = [this] { return hasRoom(); };
  store.is_failing = [this] {
    const std::lock_guard lock(mutex_);
    return !error_.empty();
  };
  store.prefetch = [this](const std::vector<KeyframeId>& ids) { prefetch(ids); };
  store.megabytes = [this] { return megabytes(); };
  store.trouble = [this] { return trouble(); };
  store.read = [this](KeyframeId id) { return read(id); };
  return store;
}

void PageKeeper::put(MapPage page) {
  const std::lock_guard lock(mutex_);
  const KeyframeId id = page.keyframe;
  if (const auto ready = ready_.find(id); ready != ready_.end()) {
    ready_mb_ -= ready->second ? megabytesOf(*ready->second) : 0;
    ready_.erase(ready);
  }
  if (reading_ == id) {
    reading_.reset();
  }
  pending_mb_ += megabytesOf(page);
  pending_[id] = std::make_shared<const MapPage>(std::move(page));
  if (pending_.size() >= kBatch) {
    to_write_.notify_all();
  }
}

bool PageKeeper::awaitRead(std::unique_lock<std::mutex>& lock, KeyframeId id) {
  const auto isThere = [&] { return ready_.contains(id); };
  if (isThere()) {
    return true;
  }
  urgent_ = id;
  to_read_.notify_all();
  if (patience_ == Patience::kWaits) {
    done_.wait(lock, isThere);
    return true;
  }
  const bool is_there = Clock::now() >= slow_until_ && done_.wait_for(lock, kPromptWait, isThere);
  if (!is_there && Clock::now() >= slow_until_) {
    slow_until_ = Clock::now() + kSlow;
  }
  return is_there;
}

TakenPage PageKeeper::take(KeyframeId id) {
  std::unique_lock lock(mutex_);
  if (const auto page = pending_.find(id); page != pending_.end()) {
    TakenPage taken{*page->second};
    pending_mb_ -= megabytesOf(*page->second);
    pending_.erase(page);
    return taken;
  }
  if (!awaitRead(lock, id)) {
    return {};
  }
  Result<MapPage> page = std::move(ready_.at(id));
  ready_.erase(id);
  if (!page) {
    ++lost_;
    return {std::nullopt, true};
  }
  ready_mb_ -= megabytesOf(*page);
  return {std::move(*page)};
}

void PageKeeper::prefetch(const std::vector<KeyframeId>& ids) {
  const std::lock_guard lock(mutex_);
  wanted_ = std::set<KeyframeId>(ids.begin(), ids.end());
  std::erase_if(ready_, [&](const auto& entry) {
    const bool goes = !wanted_.contains(entry.first) && urgent_ != entry.first;
    ready_mb_ -= goes && entry.second ? megabytesOf(*entry.second) : 0;
    return goes;
  });
  if (nextToRead()) {
    to_read_.notify_all();
  }
}

bool PageKeeper::hasRoom() {
  std::unique_lock lock(mutex_);
  const auto isFull = [&] { return pending_mb_ > kMostPendingShare * budget_mb_; };
  // A journal's pages wait for the changes that are written with them, which whoever asks here may have to hand over.
  if (patience_ == Patience::kWaits && !isJournal() && error_.empty() && isFull()) {
    to_write_.notify_all();
    done_.wait(lock, [&] { return !isFull() || !error_.empty(); });
  }
  if (!error_.empty() && Clock::now() >= retry_) {
    to_write_.notify_all();
  }
  return error_.empty() && !isFull();
}

double PageKeeper::megabytes() const {
  const std::lock_guard lock(mutex_);
  return pending_mb_ + ready_mb_;
}

bool PageKeeper::isDue(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto every = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(journal_s_));
  if (!isJournal()) {
    return false;
  }
  if (due_ == Clock::time_point{}) {
    due_ = now + every;
  }
  const bool is_early = pending_mb_ > kMostPendingShare / 2 * budget_mb_ && error_.empty();
  if (changes_ && now >= retry_) {
    to_write_.notify_all();
  }
  if ((now < due_ && !is_early) || is_writing_ || changes_) {
    return false;
  }
  due_ = now + every;
  return true;
}

bool PageKeeper::needsAll() const {
  const std::lock_guard lock(mutex_);
  return needs_all_;
}

void PageKeeper::write(MapChanges changes) {
  const std::lock_guard lock(mutex_);
  changes_ = std::move(changes);
  needs_all_ = false;
  to_write_.notify_all();
}

std::string PageKeeper::settle() {
  std::unique_lock lock(mutex_);
  is_flushed_ = true;
  to_write_.notify_all();
  done_.wait(lock, [&] { return !is_writing_ && !changes_ && !is_flushed_; });
  return error_;
}

std::optional<double> PageKeeper::savedAge(Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  return saved_ ? std::optional(std::chrono::duration<double>(now - *saved_).count()) : std::nullopt;
}

std::string PageKeeper::trouble() const {
  const std::lock_guard lock(mutex_);
  if (!error_.empty()) {
    return fmt::format(
        "what is far cannot be kept on disk ({}): mapping goes on, detail is given up oldest first when "
        "memory runs out",
        error_);
  }
  return lost_ == 0 ? "" : fmt::format("{} parts of the map could not be read back from disk: they are lost", lost_);
}

Result<MapPage> PageKeeper::read(KeyframeId id) {
  std::unique_lock lock(mutex_);
  if (const auto page = pending_.find(id); page != pending_.end()) {
    return Result<MapPage>::ok(MapPage(*page->second));
  }
  if (!awaitRead(lock, id)) {
    return Result<MapPage>::fail("not read in time");
  }
  Result<MapPage> page = std::move(ready_.at(id));
  ready_.erase(id);
  ready_mb_ -= page ? megabytesOf(*page) : 0;
  return page;
}

std::optional<PageKeeper::Job> PageKeeper::nextJob() {
  const bool can_try = error_.empty() || Clock::now() >= retry_ || is_flushed_;
  const bool is_batch =
      !isJournal() && (pending_.size() >= kBatch || is_flushed_ || pending_mb_ > kMostPendingShare / 2 * budget_mb_);
  if (!can_try || (!changes_ && (!is_batch || pending_.empty()))) {
    is_flushed_ = false;
    return std::nullopt;
  }
  Job job{std::exchange(changes_, std::nullopt), {}, Clock::now()};
  for (const auto& [id, page] : pending_) {
    job.pages.push_back(page);
  }
  return job;
}

std::string PageKeeper::carryOut(const Job& job) {
  if (!writer_) {
    Result<MapStore> opened =
        MapStore::open(path_, isJournal() ? MapStore::Safety::kDurable : MapStore::Safety::kScratch);
    if (!opened) {
      return opened.error;
    }
    writer_ = std::move(*opened.value);
  }
  return writer_->write(job.changes ? &*job.changes : nullptr, job.pages);
}

void PageKeeper::writeJobs(const std::stop_token& stop) {
  leaveSignalsToMainThread();
  giveWay();
  std::unique_lock lock(mutex_);
  while (true) {
    std::optional<Job> job;
    to_write_.wait(lock, stop, [&] {
      job = nextJob();
      done_.notify_all();
      return job.has_value();
    });
    if (!job) {
      return;
    }
    is_writing_ = true;
    lock.unlock();
    std::string error = carryOut(*job);
    lock.lock();
    is_writing_ = false;
    error_ = std::move(error);
    if (error_.empty()) {
      for (const SharedPage& page : job->pages) {
        const auto entry = pending_.find(page->keyframe);
        if (entry != pending_.end() && entry->second == page) {
          pending_mb_ -= megabytesOf(*page);
          pending_.erase(entry);
        }
      }
      saved_ = job->changes ? std::optional(job->as_of) : saved_;
    } else {
      needs_all_ |= job->changes.has_value();
      is_flushed_ = false;
      retry_ = Clock::now() + kRetry;
    }
    job.reset();
    done_.notify_all();
  }
}

std::optional<KeyframeId> PageKeeper::nextToRead() const {
  const auto isWaiting = [&](KeyframeId id) { return !ready_.contains(id) && !pending_.contains(id); };
  if (urgent_ && isWaiting(*urgent_)) {
    return urgent_;
  }
  const auto next = std::ranges::find_if(wanted_, isWaiting);
  return next == wanted_.end() ? std::nullopt : std::optional(*next);
}

void PageKeeper::readPages(const std::stop_token& stop) {
  leaveSignalsToMainThread();
  std::unique_lock lock(mutex_);
  while (to_read_.wait(lock, stop, [&] { return nextToRead().has_value(); }) && !stop.stop_requested()) {
    const KeyframeId id = *nextToRead();
    reading_ = id;
    lock.unlock();
    std::string error;
    if (!reader_) {
      Result<MapStore> opened = MapStore::openToRead(path_);
      error = opened.error;
      reader_ = std::move(opened.value);
    }
    Result<MapPage> page = reader_ ? reader_->page(id) : Result<MapPage>::fail(error);
    lock.lock();
    if (reading_ == id) {
      ready_mb_ += page ? megabytesOf(*page) : 0;
      ready_.insert_or_assign(id, std::move(page));
      urgent_ = urgent_ == id ? std::nullopt : urgent_;
    }
    reading_.reset();
    done_.notify_all();
  }
}

}  // namespace hgg
