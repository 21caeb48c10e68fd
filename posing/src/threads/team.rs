//! Threads that help one another through a frame.
//!
//! A frame is some hundred short loops that wait for each other, with little between them. Pools made for many tasks send their threads to
//! sleep in between, and waking one takes as long as such a loop. These look out for the next loop for a while. Each begins with the same
//! share of every loop, which its own cache has, and then takes what is left of the others': no loop waits for a thread that does not come.

use std::hint::spin_loop;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

/// How often a thread looks out for the next job before it sleeps although no rest was announced: some milliseconds.
const PATIENCE: u32 = 2_000_000;

/// Threads that get a share of their own.
const SHARES: usize = 8;

/// Who works together.
pub struct Team {
    shares: [Share; SHARES],
    /// The present job, as long as there are parts in a share.
    job: AtomicPtr<Job<'static>>,
    /// How many jobs there were.
    number: AtomicU32,
    /// Parts of the present job that are done.
    done: AtomicU32,
    /// Held by the thread whose job it is.
    lead: Mutex<()>,
    /// Whether members are asked at all.
    asks: AtomicBool,
    members: AtomicU32,
    /// There is no job to be expected.
    rests: AtomicBool,
    /// Threads that sleep.
    asleep: Mutex<u32>,
    wake: Condvar,
}

struct Job<'a> {
    work: &'a (dyn Fn(usize) + Sync),
}

/// Parts of the present job: 32 bits of the job's number, then 16 each of the next part and of the one after the last. In a cache line of
/// its own.
#[repr(align(64))]
struct Share(AtomicU64);

const NEXT: u64 = 1 << 16;

fn next_part(share: u64) -> Option<usize> {
    let (next, end) = (share as u32 >> 16, share as u32 & 0xFFFF);
    (next < end).then_some(next as usize)
}

impl Team {
    /// Nobody yet.
    pub const fn new() -> Self {
        Self {
            shares: [const { Share(AtomicU64::new(0)) }; SHARES],
            job: AtomicPtr::new(null_mut()),
            number: AtomicU32::new(0),
            done: AtomicU32::new(0),
            lead: Mutex::new(()),
            asks: AtomicBool::new(true),
            members: AtomicU32::new(0),
            rests: AtomicBool::new(false),
            asleep: Mutex::new(0),
            wake: Condvar::new(),
        }
    }

    /// Makes the calling thread a member, which does not come back.
    pub fn join(&self) -> ! {
        let own = 1 + self.members.fetch_add(1, Ordering::Relaxed) as usize;
        let mut seen = 0;
        loop {
            seen = self.wait_for_job_after(seen);
            self.take_parts(own);
        }
    }

    /// The number of a job after number `seen`.
    fn wait_for_job_after(&self, seen: u32) -> u32 {
        for _ in 0..PATIENCE {
            let number = self.number.load(Ordering::Acquire);
            if number != seen {
                return number;
            }
            spin_loop();
            if self.rests.load(Ordering::Relaxed) {
                break;
            }
        }
        let mut asleep = self.asleep.lock().unwrap_or_else(PoisonError::into_inner);
        *asleep += 1;
        loop {
            let number = self.number.load(Ordering::Acquire);
            if number != seen {
                *asleep -= 1;
                return number;
            }
            asleep = self.wake.wait(asleep).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// How many have joined.
    pub fn members(&self) -> usize {
        self.members.load(Ordering::Relaxed) as usize
    }

    /// Whether jobs are to be shared from now on.
    pub fn set_shares(&self, shares: bool) {
        self.asks.store(shares, Ordering::Relaxed);
    }

    /// There will be no job for a while: members sleep.
    pub fn rest(&self) {
        self.rests.store(true, Ordering::Relaxed);
    }

    /// Calls `work` with every number below `parts` (65 535 at most), on this thread and whichever members come, and returns when all is
    /// done. On this thread alone where there are no members, where they are at another job, and where they are not to be asked.
    pub fn share(&self, parts: usize, work: &(dyn Fn(usize) + Sync)) {
        let members = self.members();
        let may_share = members > 0 && self.asks.load(Ordering::Relaxed) && parts < NEXT as usize;
        let lead = if may_share { self.lead.try_lock().ok() } else { None };
        let Some(_lead) = lead else { return (0..parts).for_each(work) };
        let job = Job { work };
        self.job.store((&raw const job).cast_mut().cast(), Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
        let number = self.number.load(Ordering::Relaxed).wrapping_add(1);
        let crew = SHARES.min(1 + members);
        for (i, share) in self.shares[..crew].iter().enumerate() {
            let [next, end] = [i, i + 1].map(|i| (i * parts / crew) as u64);
            share.0.store((u64::from(number) << 32) | (next * NEXT) | end, Ordering::Release);
        }
        self.rests.store(false, Ordering::Relaxed);
        self.number.store(number, Ordering::Release);
        if *self.asleep.lock().unwrap_or_else(PoisonError::into_inner) > 0 {
            self.wake.notify_all();
        }
        self.take_parts(0);
        // `job` must outlive what members make of it.
        while (self.done.load(Ordering::Acquire) as usize) < parts {
            spin_loop();
        }
    }

    /// Takes parts of the present job until there are none, of the share `own` first.
    fn take_parts(&self, own: usize) {
        for i in 0..SHARES {
            let share = &self.shares[(own + i) % SHARES].0;
            let mut found = share.load(Ordering::Acquire);
            while let Some(part) = next_part(found) {
                let job = self.job.load(Ordering::Relaxed);
                match share.compare_exchange_weak(found, found + NEXT, Ordering::Acquire, Ordering::Acquire) {
                    Ok(_) => {
                        self.do_part(job, part);
                        found += NEXT;
                    }
                    Err(now) => found = now,
                }
            }
        }
    }

    #[allow(unsafe_code)]
    fn do_part(&self, job: *mut Job<'static>, part: usize) {
        let unwinding = AbortOnUnwinding;
        // SAFETY: the share still had this part after `job` was read, so it is the part's job; who leads it waits in `share` until all
        // parts are done, this one included.
        let job = unsafe { &*job };
        (job.work)(part);
        std::mem::forget(unwinding);
        self.done.fetch_add(1, Ordering::Release);
    }
}

/// A part that is never done would be waited for for ever.
struct AbortOnUnwinding;

impl Drop for AbortOnUnwinding {
    fn drop(&mut self) {
        std::process::abort();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::thread;

    fn team(members: usize) -> &'static Team {
        let team: &Team = Box::leak(Box::new(Team::new()));
        for _ in 0..members {
            thread::spawn(|| team.join());
        }
        while team.members() < members {
            thread::yield_now();
        }
        team
    }

    /// How often each part was done.
    fn counts(team: &Team, parts: usize) -> Vec<u32> {
        let counts: Vec<AtomicU32> = (0..parts).map(|_| AtomicU32::new(0)).collect();
        team.share(parts, &|part| {
            counts[part].fetch_add(1, Ordering::Relaxed);
        });
        counts.into_iter().map(AtomicU32::into_inner).collect()
    }

    #[test]
    fn parts_are_done_side_by_side() {
        let team = team(2);
        for _ in 0..3 {
            // Three wait for each other: on fewer threads this would never end.
            let barrier = Barrier::new(3);
            team.share(3, &|_| {
                barrier.wait();
            });
            team.rest();
        }
    }

    #[test]
    fn each_part_is_done_once_whoever_leads() {
        // More members than have shares of their own.
        let team = team(SHARES + 1);
        thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    for parts in (0..2000).map(|i| i % 37) {
                        assert_eq!(counts(team, parts), vec![1; parts]);
                    }
                });
            }
        });
    }

    #[test]
    fn without_members_within_a_part_and_where_it_is_wanted_there_is_one_thread() {
        assert_eq!(counts(&Team::new(), 5), [1; 5]);
        let team = team(1);
        team.share(4, &|_| assert_eq!(counts(team, 9), [1; 9]));
        team.set_shares(false);
        let own = thread::current().id();
        team.share(100, &|_| assert_eq!(thread::current().id(), own));
    }
}
