/* SPDX-License-Identifier: LGPL-2.1-or-later
 *
 * The protocol between a process, its guardian and the kernel's queue to the motors, for Spin.
 * Version: 0x14, that of guardian-protocol.hpp. tests/referees/guardian-model.sh checks it.
 *
 * Why it is so:
 * - The kernel sends the packets of an endpoint in the order in which they were submitted, whoever
 *   submits them. A packet that is not cancelled goes out even when its process is stopped. So rest
 *   words put the motors at rest only until the next words that somebody may still submit.
 * - A process may be stopped between its word to the guardian and the words to the motors, or
 *   between its look at the guardian's notices and either. When it continues, it first does what it
 *   had decided before. Nothing that the guardian does before that can prevent it.
 * - So one rest is not enough, and the guardian cannot see when it is. It repeats the rest until a
 *   word says that the process knows of this intervention. The process then submits no words that
 *   it decided before: it looks at the notices before each exchange, in one thread.
 * - The socket keeps the order, and a new intervention begins only after a word that knows of the
 *   one before. So one bit tells two interventions apart, as in the alternating bit protocol.
 * - A notice tells the whole state and not a change, so it may be lost or come late.
 * - A process whose word did not fit into the socket sends no force: the guardian would not expect
 *   it.
 * - A controller that answers each packet takes none while UNREAD answers wait. A stopped process
 *   reads none, so the guardian reads them when a packet of its own is not taken.
 *
 * Time is not modelled: a time limit may pass at any step, which includes every late thread.
 *
 * Variants, each of which must fail:
 *   OLD      version 0x13: the guardian rests once, then waits for a word
 *   ANYWORD  any word ends the intervention, also one that was sent before it
 *   UNTOLD   a force may follow a word that did not fit into the socket
 *   DEAF     the guardian reads no answers (with UNREAD)
 * UNREAD=n   a controller that answers each packet and takes none while n answers are unread;
 *            0: one that does not answer
 */
#ifndef UNREAD
#define UNREAD 0
#endif
#define SILENT 2 /* words without an answer: the guardian is silent */
#define TICKS 4  /* of the process, once nothing goes wrong any more */

/* Owners of a packet. */
#define FIRST 0    /* the process, in an exchange */
#define RESTING 1  /* the process, after its endpoint was blocked */
#define GUARDIAN 2

/* What goes wrong in the end. Before, any thread may take any time for any step: that is a stop. */
bool final = false; /* from now on nothing of the following changes, and time limits are kept */
bool process_runs = true, guardian_runs = true;
bool process_dead = false, guardian_dead = false;

/* The kernel and the controller. */
chan out = [3] of { bit, byte }; /* words (0: rest, 1: force), owner */
bool flying[3];                  /* by owner: its packet is in `out` */
bool cancelled = false;          /* the kernel will drop or send the packet FIRST */
bit motors = 0;                  /* 1: they have a force */
byte unread = 0;                 /* answers of the controller */
bool listening = true;           /* the process waits for an answer: the next one is its own */

/* The socket. */
chan words = [2] of { bit, bit };   /* force, intervention that the process knows of */
chan notices = [2] of { bit, bit }; /* whether the guardian intervenes, number of the intervention */

/* Of the guardian; then what the process knows of it. */
bool intervening = false;
bit intervention = 0;
bool prevented = false;
bit known = 0;

inline submit(what, owner) {
  flying[owner] = true;
  out ! what, owner
}

active proctype Controller() {
  bit what;
  byte owner;
  do
  :: atomic {
       (UNREAD == 0 || unread < UNREAD) && nempty(out) ->
       out ? what, owner;
       motors = what;
       flying[owner] = false;
       if
       :: owner == FIRST -> cancelled = false
       :: else
       fi;
       if
       :: UNREAD == 0
       :: UNREAD > 0 && listening -> listening = false
       :: UNREAD > 0 && !listening -> unread++
       fi;
       what = 0;
       owner = 0
     }
  :: atomic {
       cancelled ->
       if
       :: out ?? 0, FIRST
       :: out ?? 1, FIRST
       fi;
       cancelled = false;
       flying[FIRST] = false
     }
  od
}

inline read_notices() {
  do
  :: notices ? prevented, known -> unanswered = 0
  :: empty(notices) -> break
  od
}

/* Sends a word if it is time or something has changed. */
inline send_word(must) {
  permitted = !guardian_dead;
  if
  :: !guardian_dead && (must || unsent || force != told || known != said) ->
       if
       :: nfull(words) ->
            words ! force, known;
            told = force;
            said = known;
            unsent = false
       :: full(words) ->
#ifdef UNTOLD
            told = !force
#else
            unsent = true;
            permitted = false
#endif
       fi;
       if
       :: unanswered < SILENT -> unanswered++
       :: else
       fi
  :: else
  fi;
  permitted = permitted && !prevented && unanswered < SILENT
}

/* Takes the answers of the controller. */
inline listen() {
  do
  :: UNREAD > 0 && !listening && unread > 0 -> unread--
  :: UNREAD > 0 && !listening && unread == 0 -> listening = true
  :: UNREAD == 0 || listening -> break
  od
}

active proctype Process() provided (process_runs) {
  bit wanted, sent, force, told, said;
  bool permitted, resting, must, unsent;
  byte unanswered = 0, ticks = 0;
  do
  :: atomic {
       /* In the end, the guardian answers in time. */
       !final || !guardian_runs || empty(words) ->
       if
       :: final && ticks == TICKS -> break
       :: final && ticks < TICKS -> ticks++
       :: !final
       fi;
       if
       :: wanted = 0
       :: wanted = 1
       fi;
       force = force || wanted;
       read_notices()
     };
     atomic {
       if
       :: must = true
       :: !final -> must = false /* not in every exchange */
       fi;
       send_word(must);
       must = false;
       sent = wanted && permitted;
       assert(ticks < TICKS || !guardian_runs || (permitted && !intervening)); /* both go on */
       wanted = 0;
       permitted = false
     };
     atomic { listen() };
     atomic {
       if
       :: resting || flying[FIRST] -> sent = 0
       :: else ->
#ifndef OLD
            assert(!sent || guardian_dead || intervening || known == intervention);
#endif
            submit(sent, FIRST)
       fi
     };
     do
     :: atomic { resting && !flying[FIRST] && !flying[RESTING] -> resting = false; force = 0; break }
     :: atomic { !resting && !flying[FIRST] -> force = sent; break }
     :: atomic { UNREAD > 0 && !listening -> listen() }
     :: atomic { /* the deadline */
          !final && (resting || flying[FIRST]) ->
          if
          :: !resting -> cancelled = true
          :: resting
          fi
        };
        atomic {
          if
          :: !resting -> submit(0, RESTING); resting = true
          :: resting
          fi;
          break
        }
     od;
     atomic {
       sent = 0;
       read_notices()
     };
     atomic {
       send_word(false);
       permitted = false
     }
  od
}

inline notify() {
  if
  :: nfull(notices) -> notices ! intervening, intervention
  :: full(notices) /* lost */
  fi
}

inline rest() {
  atomic { submit(0, GUARDIAN) };
  if
  :: atomic { !flying[GUARDIAN] -> delivered = true }
  :: atomic { /* the time limit */
       flying[GUARDIAN] && (!final || (UNREAD > 0 && unread == UNREAD)) ->
       out ?? 0, GUARDIAN;
       flying[GUARDIAN] = false;
#ifdef DEAF
       !final /* else for ever */
#else
       do
       :: unread > 0 -> unread-- /* the process does not listen, or none would wait */
       :: unread == 0 -> break
       od
#endif
     }
  fi
}

active proctype Guardian() provided (guardian_runs) {
  bit force, told_force, told_known;
  bool delivered, last;
  do
  :: atomic {
       words ? told_force, told_known ->
       force = told_force;
#if defined(OLD)
       intervening = intervening && force;
#elif defined(ANYWORD)
       intervening = false;
#else
       intervening = intervening && told_known != intervention;
#endif
       told_force = 0;
       told_known = 0;
       notify()
     }
  :: atomic { /* silence for too long: of a late process, too */
       empty(words) && !process_dead && (force || intervening) && (!final || !process_runs) ->
       last = final
     };
     atomic {
       if
       :: !intervening ->
            intervening = true;
            intervention = 1 - intervention;
            notify()
       :: else
       fi
     };
     rest();
     atomic {
#ifdef OLD
       if
       :: delivered -> force = 0; intervening = false; notify()
       :: else
       fi;
#else
       if
       :: delivered && last -> break /* all further ones are the same */
       :: else
       fi;
#endif
       delivered = false;
       last = false
     }
  :: atomic { empty(words) && process_dead -> break }
  od;
  if
  :: !last -> /* the process has ended */
       do
       :: !delivered -> rest()
       :: !delivered && !force && !intervening -> break /* it gives up */
       :: delivered -> break
       od
  :: last
  fi
}

/* In the end one of the two stands still for ever, or is dead, or neither. */
active proctype Environment() {
  atomic {
    if
    :: process_runs = false
    :: guardian_runs = false
    :: process_runs = false; process_dead = true
    :: guardian_runs = false; guardian_dead = true
    :: skip
    fi;
    final = true
  }
}

/* When nothing happens any more: no force without a process and a guardian that both go on. */
active proctype Quiet() {
  timeout -> assert(final && ((process_runs && guardian_runs) || motors == 0))
}
