// SPDX-License-Identifier: GPL-2.0-or-later
//
// What a client has the agent create: a participant, a publisher and a subscriber in it, and for each endpoint a topic and a data
// writer or data reader, or the answering end of a service. In binary, as micro-ROS has it: OMG DDS-XRCE 1.0, 7.7.3 and 8.3.5.2,
// and where a topic names its type and a writer its topic, include/uxr/client/core/type/xrce_types.h of Micro-XRCE-DDS-Client.

#pragma once

#include "xrce/cdr.h"

enum xrce_kind { XRCE_WRITES, XRCE_READS, XRCE_SERVES };

struct xrce_endpoint {
    enum xrce_kind kind;
    bool best_effort;        // else reliable; the newest sample alone is of interest in either case
    const char *topic;       // as rt/NAME; of a service the requests'
    const char *type;        // as PACKAGE::msg::dds_::NAME_; of a service the requests'
    const char *reply_topic; // of a service, as the next two
    const char *reply_type;
    const char *service;
};

// How many objects so many endpoints come to at most.
#define XRCE_OBJECTS(endpoints) (3u + 2u * (endpoints))

// The id of the object at a place in the order of creation; 0 if the place is empty.
uint16_t xrce_object_id(const struct xrce_endpoint *endpoints, uint32_t place);

// That which an endpoint writes, reads or serves by.
uint16_t xrce_endpoint_id(const struct xrce_endpoint *endpoints, uint32_t endpoint);

// What CREATE says of it behind its id.
void xrce_put_object(struct cdr_writer *out, const struct xrce_endpoint *endpoints, uint32_t place, int16_t domain);
