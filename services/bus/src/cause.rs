//! What iceoryx2's errors mean, in plain words.

use iceoryx2::node::NodeCreationFailure;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::listener::ListenerCreateError;
use iceoryx2::port::notifier::NotifierCreateError;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::port::{LoanError, ReceiveError, SendError};
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError, RequestResponseOpenError, RequestResponseOpenOrCreateError,
};
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;
use thiserror::Error;

/// Why shared memory can't be used as asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Cause {
    /// There is no such service.
    #[error("it does not exist")]
    Absent,
    /// It is being created or removed.
    #[error("it is being started or stopped; try again")]
    InFlux,
    /// All places are taken.
    #[error("all places are taken")]
    Full,
    /// The service exists with smaller settings than asked for.
    #[error(
        "it is still open with smaller settings; close the programs that use it, or keep \
         max_clients, requests_per_client, max_recorders and tap_buffer as they were"
    )]
    Smaller,
    /// The service exists with other messages.
    #[error("it is open with other messages, by another version of this program")]
    OtherMessages,
    /// The service was created by another version of iceoryx2.
    #[error("it was created with another version of iceoryx2")]
    OtherIceoryx,
    /// The operating system forbids it.
    #[error("permission denied; its files in /dev/shm belong to another user")]
    Permissions,
    /// A signal came.
    #[error("interrupted by a signal")]
    Interrupted,
    /// Files are missing or damaged.
    #[error(
        "its files in /dev/shm or under the root directory are missing or damaged; end the programs in it, \
         and try again"
    )]
    Damaged,
    /// There is no memory left for it.
    #[error("no shared memory is left; enlarge /dev/shm")]
    OutOfMemory,
    /// The message is larger than the memory set aside.
    #[error("the message is larger than its memory")]
    TooLarge,
    /// The other side has left or its connection broke.
    #[error("the connection is broken")]
    Disconnected,
    /// Too many messages are held at a time.
    #[error("too many messages are in use at a time")]
    TooMany,
    /// Anything else.
    #[error("internal error of iceoryx2")]
    Internal,
}

impl From<NodeCreationFailure> for Cause {
    fn from(error: NodeCreationFailure) -> Self {
        match error {
            NodeCreationFailure::InsufficientPermissions => Self::Permissions,
            NodeCreationFailure::SystemCorrupted => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<RequestResponseOpenError> for Cause {
    fn from(error: RequestResponseOpenError) -> Self {
        use RequestResponseOpenError as E;
        match error {
            E::DoesNotExist => Self::Absent,
            E::HangsInCreation | E::IsMarkedForDestruction => Self::InFlux,
            E::ExceedsMaxNumberOfNodes => Self::Full,
            E::DoesNotSupportRequestedAmountOfClientRequestLoans
            | E::DoesNotSupportRequestedAmountOfActiveRequestsPerClient
            | E::DoesNotSupportRequestedResponseBufferSize
            | E::DoesNotSupportRequestedAmountOfServers
            | E::DoesNotSupportRequestedAmountOfClients
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::DoesNotSupportRequestedAmountOfBorrowedResponsesPerPendingResponse => {
                Self::Smaller
            }
            E::IncompatibleRequestOrResponseType
            | E::IncompatibleAttributes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleOverflowBehaviorForRequests
            | E::IncompatibleOverflowBehaviorForResponses
            | E::IncompatibleBehaviorForFireAndForgetRequests => Self::OtherMessages,
            E::VersionMismatch => Self::OtherIceoryx,
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<RequestResponseCreateError> for Cause {
    fn from(error: RequestResponseCreateError) -> Self {
        use RequestResponseCreateError as E;
        match error {
            E::AlreadyExists | E::IsBeingCreatedByAnotherInstance | E::HangsInCreation => {
                Self::InFlux
            }
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<RequestResponseOpenOrCreateError> for Cause {
    fn from(error: RequestResponseOpenOrCreateError) -> Self {
        use RequestResponseOpenOrCreateError as E;
        match error {
            E::RequestResponseOpenError(error) => error.into(),
            E::RequestResponseCreateError(error) => error.into(),
            E::SystemInFlux => Self::InFlux,
        }
    }
}

impl From<EventOpenError> for Cause {
    fn from(error: EventOpenError) -> Self {
        use EventOpenError as E;
        match error {
            E::DoesNotExist => Self::Absent,
            E::HangsInCreation | E::IsMarkedForDestruction => Self::InFlux,
            E::ExceedsMaxNumberOfNodes => Self::Full,
            E::DoesNotSupportRequestedAmountOfNotifiers
            | E::DoesNotSupportRequestedAmountOfListeners
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::DoesNotSupportRequestedMaxEventId => Self::Smaller,
            E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleDeadline
            | E::IncompatibleNotifierCreatedEvent
            | E::IncompatibleNotifierDroppedEvent
            | E::IncompatibleNotifierDeadEvent => Self::OtherMessages,
            E::VersionMismatch => Self::OtherIceoryx,
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<EventCreateError> for Cause {
    fn from(error: EventCreateError) -> Self {
        use EventCreateError as E;
        match error {
            E::AlreadyExists | E::IsBeingCreatedByAnotherInstance => Self::InFlux,
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<EventOpenOrCreateError> for Cause {
    fn from(error: EventOpenOrCreateError) -> Self {
        use EventOpenOrCreateError as E;
        match error {
            E::EventOpenError(error) => error.into(),
            E::EventCreateError(error) => error.into(),
            E::SystemInFlux => Self::InFlux,
        }
    }
}

impl From<PublishSubscribeOpenError> for Cause {
    fn from(error: PublishSubscribeOpenError) -> Self {
        use PublishSubscribeOpenError as E;
        match error {
            E::DoesNotExist => Self::Absent,
            E::HangsInCreation | E::IsMarkedForDestruction => Self::InFlux,
            E::ExceedsMaxNumberOfNodes => Self::Full,
            E::DoesNotSupportRequestedMinBufferSize
            | E::DoesNotSupportRequestedMinHistorySize
            | E::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | E::DoesNotSupportRequestedAmountOfPublishers
            | E::DoesNotSupportRequestedAmountOfSubscribers
            | E::DoesNotSupportRequestedAmountOfNodes => Self::Smaller,
            E::IncompatibleTypes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleOverflowBehavior => Self::OtherMessages,
            E::VersionMismatch => Self::OtherIceoryx,
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<PublishSubscribeCreateError> for Cause {
    fn from(error: PublishSubscribeCreateError) -> Self {
        use PublishSubscribeCreateError as E;
        match error {
            E::AlreadyExists | E::IsBeingCreatedByAnotherInstance | E::HangsInCreation => {
                Self::InFlux
            }
            E::InsufficientPermissions => Self::Permissions,
            E::Interrupt => Self::Interrupted,
            E::ServiceInCorruptedState => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<PublishSubscribeOpenOrCreateError> for Cause {
    fn from(error: PublishSubscribeOpenOrCreateError) -> Self {
        use PublishSubscribeOpenOrCreateError as E;
        match error {
            E::PublishSubscribeOpenError(error) => error.into(),
            E::PublishSubscribeCreateError(error) => error.into(),
            E::SystemInFlux => Self::InFlux,
        }
    }
}

impl From<ClientCreateError> for Cause {
    fn from(error: ClientCreateError) -> Self {
        match error {
            ClientCreateError::ExceedsMaxSupportedClients => Self::Full,
            ClientCreateError::UnableToCreateDataSegment => Self::OutOfMemory,
            _ => Self::Internal,
        }
    }
}

impl From<ServerCreateError> for Cause {
    fn from(error: ServerCreateError) -> Self {
        match error {
            ServerCreateError::ExceedsMaxSupportedServers => Self::Full,
            ServerCreateError::UnableToCreateDataSegment => Self::OutOfMemory,
            _ => Self::Internal,
        }
    }
}

impl From<NotifierCreateError> for Cause {
    fn from(error: NotifierCreateError) -> Self {
        match error {
            NotifierCreateError::ExceedsMaxSupportedNotifiers => Self::Full,
            _ => Self::Internal,
        }
    }
}

impl From<ListenerCreateError> for Cause {
    fn from(error: ListenerCreateError) -> Self {
        match error {
            ListenerCreateError::ExceedsMaxSupportedListeners => Self::Full,
            ListenerCreateError::ResourceCreationFailed => Self::Damaged,
            _ => Self::Internal,
        }
    }
}

impl From<PublisherCreateError> for Cause {
    fn from(error: PublisherCreateError) -> Self {
        match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => Self::Full,
            PublisherCreateError::UnableToCreateDataSegment => Self::OutOfMemory,
            _ => Self::Internal,
        }
    }
}

impl From<SubscriberCreateError> for Cause {
    fn from(error: SubscriberCreateError) -> Self {
        match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => Self::Full,
            SubscriberCreateError::BufferSizeExceedsMaxSupportedBufferSizeOfService => {
                Self::Smaller
            }
            _ => Self::Internal,
        }
    }
}

impl From<LoanError> for Cause {
    fn from(error: LoanError) -> Self {
        match error {
            LoanError::OutOfMemory => Self::OutOfMemory,
            LoanError::ExceedsMaxLoans => Self::TooMany,
            LoanError::ExceedsMaxLoanSize => Self::TooLarge,
            LoanError::InternalFailure => Self::Internal,
        }
    }
}

impl From<SendError> for Cause {
    fn from(error: SendError) -> Self {
        match error {
            SendError::LoanError(error) => error.into(),
            SendError::ConnectionBrokenSinceSenderNoLongerExists
            | SendError::ConnectionCorrupted
            | SendError::ConnectionError(_)
            | SendError::UnableToDeliver => Self::Disconnected,
            SendError::InternalError => Self::Internal,
        }
    }
}

impl From<RequestSendError> for Cause {
    fn from(error: RequestSendError) -> Self {
        match error {
            RequestSendError::ExceedsMaxActiveRequests => Self::TooMany,
            RequestSendError::SendError(error) => error.into(),
        }
    }
}

impl From<ReceiveError> for Cause {
    fn from(error: ReceiveError) -> Self {
        match error {
            ReceiveError::ExceedsMaxBorrows => Self::TooMany,
            ReceiveError::ConnectionFailure(_) => Self::Disconnected,
        }
    }
}
