// SPDX-License-Identifier: GPL-2.0-or-later
//
// A client of DDS-XRCE over a serial line: no heap, nothing waits, all of it bounded. It looks for an agent, asks it for a
// session, has it create its objects, and writes and reads samples; where the agent is lost, or has lost the session, all of
// that begins anew.
//
//     xrce_begin(&client, &config, now);
//     while (line_get(&byte))
//         xrce_receive(&client, byte, now);
//     wait = xrce_advance(&client, now); // behind bytes, and when this time has passed
//     xrce_write(&client, endpoint, sample, count, now);
//
// The specification is OMG DDS-XRCE 1.0 (formal/2020-02-01); where eProsima's agents and micro-ROS differ, theirs is spoken.
// Times are in ms and go round. Samples are CDR without a header.

#pragma once

#include "xrce/cdr.h"
#include "xrce/frames.h"
#include "xrce/objects.h"
#include "xrce/streams.h"

#define XRCE_MOST_ENDPOINTS 14u // so that all objects have a bit of a word
#define XRCE_IDENTITY 24u       // bytes before a request and its reply: whose it is (SampleIdentity of DDS-RPC)

enum xrce_state {
    XRCE_SEEKING,  // pings
    XRCE_ASKING,   // for a session
    XRCE_CREATING, // its objects
    XRCE_OPEN,     // samples pass
};

struct xrce_times {
    uint32_t ping;  // between pings for an agent
    uint32_t retry; // between requests for a session; after three an agent is looked for again
    uint32_t quiet; // after such a silence of the agent it is asked whether the session is there, and again as often
    uint32_t lost;  // after such a silence, or so long without an acknowledgement, or without the next object confirmed, the
                    // agent counts as lost
};

struct xrce_client;

struct xrce_config {
    uint8_t key[4];     // whose session it is: another one for each client of an agent, the same after a reset
    uint8_t session_id; // 0x81 to 0xFF: no key stands in the headers
    int16_t domain;
    struct xrce_times times;
    const struct xrce_endpoint *endpoints;
    uint32_t endpoint_count; // XRCE_MOST_ENDPOINTS at most
    // Puts a frame on the line, or nothing where there is no room for all of it.
    void (*send)(void *context, const uint8_t *frame, uint32_t count);
    // A sample came at an endpoint; `in` begins with it, and of a service with XRCE_IDENTITY octets.
    void (*heard)(void *context, uint32_t endpoint, struct cdr_reader *in);
    // Optional. The state changes.
    void (*changed)(void *context, enum xrce_state state);
    void *context;
};

struct xrce_client {
    const struct xrce_config *config;
    enum xrce_state state;
    uint32_t due;   // of ping, request or question
    uint32_t tries; // of the request for a session
    uint32_t heard; // when the agent was heard last, in the session
    uint32_t progressed; // when the last object was confirmed; before, when they began to be created
    uint32_t asked, confirmed; // objects, a bit each
    uint32_t next_place;       // the next one to be created
    uint16_t best_effort_out, best_effort_in;
    struct xrce_reader reader;
    struct xrce_output output;
    struct xrce_input input;
    bool owes_acknack;
    uint8_t whole[XRCE_WHOLE]; // of fragments
    uint32_t whole_count;
    bool whole_bad;
    uint8_t message[XRCE_MTU], frame[XRCE_FRAME];
};

// False, and nothing begun, if there are more endpoints than XRCE_MOST_ENDPOINTS.
bool xrce_begin(struct xrce_client *client, const struct xrce_config *config, uint32_t now);

void xrce_receive(struct xrce_client *client, uint8_t byte, uint32_t now);

// Does what is due. Returns in how many ms there is something to do again.
uint32_t xrce_advance(struct xrce_client *client, uint32_t now);

// Sends a sample, or a reply behind the identity of its request. False, and nothing sent, if there is no session with all its
// objects, no room in the window of a reliable one, or in a message.
bool xrce_write(struct xrce_client *client, uint32_t endpoint, const uint8_t *sample, uint32_t count, uint32_t now);

// Ends the session: the agent deletes all that was created in it. Another one is looked for as from the begin.
void xrce_end(struct xrce_client *client, uint32_t now);
