// Generated from api_schema/ by `npm run api`.

export interface paths {
    "/healthz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Whether the process answers
         * @description Answers as long as the process runs, whatever else is down. For a liveness probe.
         */
        get: operations["getHealth"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/metrics": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Metrics for Prometheus
         * @description Tell requests by route, queue lengths, jobs by state, live workers; no names, ids or secrets.
         */
        get: operations["getMetrics"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/readyz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Whether requests can be served
         * @description Asks the database, the queue and the object store. For a readiness probe.
         *
         *     The queue being down does not make the gateway refuse jobs (they are kept in the database and sent later), but it
         *     is told here, since nothing would run.
         */
        get: operations["getReadiness"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/assets": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your assets
         * @description Newest first, if no other order is asked for.
         */
        get: operations["listAssets"];
        put?: never;
        /**
         * Upload a file at once
         * @description Send one file as the form field `file`. Large files are better sent resumably, through `/v1/uploads`.
         *
         *     The file's kind is told from its content. The same bytes are stored once, however often they are sent.
         */
        post: operations["createAsset"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/assets/{asset_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What an asset is
         * @description Kind, format, size and hash of an asset, and what its header tells.
         */
        get: operations["getAsset"];
        put?: never;
        post?: never;
        /**
         * Delete an asset
         * @description Jobs that are under way keep what they read; the bytes go when nothing refers to them any more.
         */
        delete: operations["deleteAsset"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/assets/{asset_id}/content": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * An asset's bytes
         * @description In whole or in part (`Range`). Sent so that no browser runs it.
         */
        get: operations["getAssetContent"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your batches
         * @description Newest first, if no other order is asked for.
         */
        get: operations["listBatches"];
        put?: never;
        /**
         * Ask for many jobs
         * @description Create all jobs, or none where an item is not valid. As NDJSON the items may come as they are made.
         */
        post: operations["createBatch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches/{batch_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * How a batch is
         * @description How many of its jobs are in which state; the jobs themselves: `GET /v1/jobs?batch_id=…`.
         */
        get: operations["getBatch"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches/{batch_id}/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Cancel a batch
         * @description Cancel what has not ended: what waits ends at once, what runs within a second or two.
         */
        post: operations["cancelBatch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches/{batch_id}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Follow a batch
         * @description How the batch stands, and then each change of its counts.
         */
        get: operations["streamBatchEvents"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches/{batch_id}/results": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The jobs of a batch
         * @description Streamed as NDJSON, however many there are.
         */
        get: operations["streamBatchResults"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/batches/{batch_id}/retry": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Run what failed of a batch again
         * @description Only the jobs that failed or crashed.
         */
        post: operations["retryBatch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/collections": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your collections
         * @description Newest first, each with the number of its shapes.
         */
        get: operations["listCollections"];
        put?: never;
        /**
         * Make a collection
         * @description Its name is not used yet. One is also made by the first shape that names a collection which does not exist.
         */
        post: operations["createCollection"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/collections/{collection_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What a collection is
         * @description Name, description and number of shapes of a collection.
         */
        get: operations["getCollection"];
        put?: never;
        post?: never;
        /**
         * Delete a collection
         * @description Delete it for good. The meshes that its shapes were made of stay.
         */
        delete: operations["deleteCollection"];
        options?: never;
        head?: never;
        /**
         * Change a collection
         * @description Change its name, description or metadata; what the request leaves out stays.
         */
        patch: operations["updateCollection"];
        trace?: never;
    };
    "/v1/collections/{collection_id}/reindex": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Index a collection's outdated shapes again
         * @description Make a batch of the shapes that an older version has indexed, at most as many as a batch may have.
         *
         *     Each is replaced as a whole at the end of its job; until then the old one is shown. Shapes whose mesh was deleted
         *     are left out.
         */
        post: operations["reindexCollection"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/info": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Version and limits of the server
         * @description Needs no key, since it tells whether one is needed.
         */
        get: operations["getInfo"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your jobs
         * @description Newest first, if no other order is asked for. Jobs that have not ended, or never began, took the least time.
         */
        get: operations["listJobs"];
        put?: never;
        /**
         * Ask for a job
         * @description Queue a job, which can be followed at once. With an `Idempotency-Key` a repeated request makes no second one.
         */
        post: operations["createJob"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * How a job is
         * @description State, progress, result and artifacts of a job, or why it failed.
         */
        get: operations["getJob"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}/artifacts/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A file that a job made
         * @description In whole or in part (`Range`). Results have an expiry (`expires_at` of the job); afterwards: 410.
         */
        get: operations["getArtifact"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Cancel a job
         * @description End a queued job at once, a running one within a second or two.
         */
        post: operations["cancelJob"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Follow a job
         * @description Everything that happened after the event that `Last-Event-ID` (or `after`) names, then what happens.
         *
         *     A comment comes every 15 seconds in which nothing does.
         */
        get: operations["streamJobEvents"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}/preview": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * How a running job's result looks so far
         * @description Events and the job itself tell the number of the newest (`preview`), so that nobody asks in vain.
         */
        get: operations["getJobPreview"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{job_id}/retry": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Run a job again
         * @description For a job that failed, crashed or was cancelled.
         */
        post: operations["retryJob"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your keys
         * @description List the keys of your owner that are not revoked, newest first, without their secrets.
         */
        get: operations["listKeys"];
        put?: never;
        /**
         * Make a key
         * @description Make a key to the same things as yours, within its scopes. Its secret is shown in this answer and never again.
         */
        post: operations["createKey"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys/{key_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /**
         * Revoke a key
         * @description From now on the key is refused. It cannot be taken back.
         */
        delete: operations["deleteKey"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/kinds": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What jobs there are
         * @description Each kind's inputs, parameters and result as JSON schemas, its limits, and how many workers serve it now.
         */
        get: operations["listKinds"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/labels": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Which labels your shapes carry
         * @description Names and values with the number of shapes that carry them, the most frequent first.
         */
        get: operations["listShapeLabels"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/search": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Find shapes like an example
         * @description Answer a query by a stored shape at once; an uploaded mesh is indexed first, in a job, which needs `write`.
         *
         *     What takes longer than `wait` is answered with the job: follow it, then ask `/v1/search/{job_id}`.
         */
        post: operations["search"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/search/{job_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What a search's job has found
         * @description Return the answer, or the job as long as it has none. Shapes that were deleted meanwhile are left out.
         */
        get: operations["getSearch"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/shapes": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List your shapes
         * @description Newest first, if no other order is asked for.
         */
        get: operations["listShapes"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/shapes/{shape_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What a shape is
         * @description Where it belongs, what its mesh is like, what was done to it before it was analysed, and its levels of parts.
         */
        get: operations["getShape"];
        put?: never;
        post?: never;
        /**
         * Delete a shape
         * @description No search finds it any more. The mesh that it was made of stays.
         */
        delete: operations["deleteShape"];
        options?: never;
        head?: never;
        /**
         * Change a shape
         * @description Its name, collection, labels or metadata; what the request leaves out stays as it is.
         */
        patch: operations["updateShape"];
        trace?: never;
    };
    "/v1/shapes/{shape_id}/{file}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A shape's graph, or what viewers show of it
         * @description One of its files.
         *
         *     - `arg`: the attributed relational graph, in the binary form that is described beside this interface's schema.
         *     - `mesh.glb`: binary glTF, small enough to be shown; the mesh as it was uploaded is the asset's content.
         *     - `preview.png`: a picture for lists and results.
         *     - `components`: JSON, for each level the part of every vertex of `mesh.glb`, so that matched parts can be colored
         *       alike.
         */
        get: operations["getShapeFile"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/shapes/{shape_id}/reindex": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Index a shape again
         * @description Queue a job that replaces it as a whole; until its end the old one is shown.
         */
        post: operations["reindexShape"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/uploads": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Begin an upload
         * @description Tell the length (or defer it) and get an address for the bytes; the first of them may come along as the body.
         */
        post: operations["createUpload"];
        delete?: never;
        /**
         * What of tus is spoken here
         * @description Version, extensions, largest size and checksum algorithms.
         */
        options: operations["getUploadCapabilities"];
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/uploads/{upload_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /**
         * Give up an upload
         * @description Remove what was sent. The asset of a finished upload stays.
         */
        delete: operations["deleteUpload"];
        options?: never;
        /**
         * Where an upload stands
         * @description From this offset the upload continues; a finished one names its asset.
         */
        head: operations["getUpload"];
        /**
         * Send bytes of an upload
         * @description Send bytes. What arrives is kept, also when the connection breaks, unless a checksum came that cannot be checked.
         *
         *     The answer to the last bytes names the asset in `Upload-Asset-Id`.
         */
        patch: operations["appendToUpload"];
        trace?: never;
    };
    "/v1/usage": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What you have on the server
         * @description Your jobs by state, and what your uploads and results take.
         */
        get: operations["getUsage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /**
         * Alignment
         * @description Where an input lay relative to the volume after contrast.
         */
        Alignment: {
            /** Degrees */
            degrees: number;
            /** Input */
            input: string;
            /** Moved */
            moved: boolean;
            /** Mutual Information */
            mutual_information: number;
            /** Mutual Information Before */
            mutual_information_before: number;
            /** Shift Mm */
            shift_mm: number;
        };
        /**
         * ArtifactView
         * @description One file that a job made.
         */
        ArtifactView: {
            /** Media Type */
            media_type: string;
            /** Name */
            name: string;
            /** Sha256 */
            sha256: string;
            /** Size */
            size: number;
            /** Url */
            url: string;
        };
        /**
         * AssetKind
         * @description What an asset can be used as.
         * @enum {string}
         */
        AssetKind: "volume" | "mesh" | "sequence" | "motion";
        /**
         * AssetView
         * @description An uploaded file, addressed by its content.
         */
        AssetView: {
            /** Content Url */
            content_url: string;
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /**
             * Details
             * @default {}
             */
            details: {
                [key: string]: unknown;
            };
            /** Filename */
            filename: string;
            /** Format */
            format: string;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            kind: components["schemas"]["AssetKind"];
            /** Media Type */
            media_type: string;
            /** Sha256 */
            sha256: string;
            /** Size */
            size: number;
        };
        /**
         * BatchCreate
         * @description A request for many jobs of one kind.
         */
        BatchCreate: {
            /** Items */
            items: components["schemas"]["BatchItem"][];
            /** Kind */
            kind: string;
            /**
             * Params
             * @default {}
             */
            params: {
                [key: string]: unknown;
            };
        };
        /**
         * BatchEvent
         * @description One event of a batch's stream, sent when its counts change; ``seq`` is the SSE id.
         */
        BatchEvent: {
            /**
             * Batch Id
             * Format: uuid
             */
            batch_id: string;
            /** Counts */
            counts: {
                [key: string]: number;
            };
            /** Finished */
            finished: boolean;
            /** Seq */
            seq: number;
        };
        /**
         * BatchHeader
         * @description The first line of a batch sent as NDJSON; every further line is a `BatchItem`.
         */
        BatchHeader: {
            /** Kind */
            kind: string;
            /**
             * Params
             * @default {}
             */
            params: {
                [key: string]: unknown;
            };
        };
        /**
         * BatchItem
         * @description One item of a batch.
         */
        BatchItem: {
            /** Inputs */
            inputs: {
                [key: string]: string | string[];
            };
            /**
             * Params
             * @default {}
             */
            params: {
                [key: string]: unknown;
            };
        };
        /**
         * BatchResult
         * @description One line of a batch's results.
         */
        BatchResult: {
            /** Index */
            index: number;
            job: components["schemas"]["JobView"];
        };
        /**
         * BatchView
         * @description A batch as it is now.
         */
        BatchView: {
            /** Counts */
            counts: {
                [key: string]: number;
            };
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Finished */
            finished: boolean;
            /** Finished At */
            finished_at?: string | null;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Kind */
            kind: string;
            /** Params */
            params: {
                [key: string]: unknown;
            };
            /** Total */
            total: number;
        };
        /**
         * CheckView
         * @description What one part answered.
         */
        CheckView: {
            /**
             * Detail
             * @default
             */
            detail: string;
            /** Seconds */
            seconds: number;
            /**
             * Status
             * @enum {string}
             */
            status: "ok" | "down";
        };
        /**
         * CollectionCreate
         * @description A request for a collection.
         */
        CollectionCreate: {
            /**
             * Description
             * @default
             */
            description: string;
            /**
             * Metadata
             * @default {}
             */
            metadata: {
                [key: string]: unknown;
            };
            /** Name */
            name: string;
        };
        /**
         * CollectionUpdate
         * @description What shall change of a collection; what is left out stays.
         */
        CollectionUpdate: {
            /** Description */
            description?: string | null;
            /** Metadata */
            metadata?: {
                [key: string]: unknown;
            } | null;
            /** Name */
            name?: string | null;
        };
        /**
         * CollectionView
         * @description Shapes that belong together.
         */
        CollectionView: {
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Description */
            description: string;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Metadata */
            metadata: {
                [key: string]: unknown;
            };
            /** Name */
            name: string;
            /** Outdated */
            outdated: number;
            /** Shapes */
            shapes: number;
        };
        /**
         * FieldProblem
         * @description One place of a request that is not valid; ``errors`` of a `Problem` lists them.
         */
        FieldProblem: {
            /** Location */
            location: string;
            /** Message */
            message: string;
        };
        /**
         * HealthView
         * @description The process answers.
         */
        HealthView: {
            /**
             * Status
             * @default ok
             * @constant
             */
            status: "ok";
        };
        /**
         * IndexStage
         * @description How long one stage took, in wall time.
         */
        IndexStage: {
            /** Name */
            name: string;
            /** Seconds */
            seconds: number;
        };
        /**
         * JobCreate
         * @description A request for one job.
         */
        JobCreate: {
            /** Inputs */
            inputs: {
                [key: string]: string | string[];
            };
            /** Kind */
            kind: string;
            /**
             * Params
             * @default {}
             */
            params: {
                [key: string]: unknown;
            };
        };
        /**
         * JobErrorView
         * @description Why a job failed or crashed.
         */
        JobErrorView: {
            /** Code */
            code: string;
            /**
             * Hint
             * @default
             */
            hint: string;
            /** Message */
            message: string;
        };
        /**
         * JobEvent
         * @description One event of a job's stream; ``seq`` is the SSE id.
         */
        JobEvent: {
            /**
             * At
             * Format: date-time
             */
            at: string;
            /**
             * Fraction
             * @default 0
             */
            fraction: number;
            /**
             * Job Id
             * Format: uuid
             */
            job_id: string;
            /**
             * Message
             * @default
             */
            message: string;
            /**
             * Preview
             * @default 0
             */
            preview: number;
            /** Seq */
            seq: number;
            /**
             * Stage
             * @default
             */
            stage: string;
            state: components["schemas"]["JobState"];
            /**
             * Type
             * @enum {string}
             */
            type: "state" | "progress";
        };
        /**
         * JobKindView
         * @description What ``GET /v1/kinds`` tells of a job kind.
         */
        JobKindView: {
            /** Inputs */
            inputs: {
                [key: string]: {
                    [key: string]: unknown;
                };
            };
            /** Memory Limit */
            memory_limit: number;
            /** Name */
            name: string;
            /** Params Schema */
            params_schema: {
                [key: string]: unknown;
            };
            /** Result Schema */
            result_schema: {
                [key: string]: unknown;
            };
            /** Service */
            service: string;
            /** Stages */
            stages: string[];
            /** Summary */
            summary: string;
            /** Time Limit */
            time_limit: number;
            /** Workers */
            workers: number;
        };
        /**
         * JobState
         * @description Where a job is; see `TRANSITIONS`.
         * @enum {string}
         */
        JobState: "queued" | "running" | "cancelling" | "succeeded" | "failed" | "crashed" | "cancelled";
        /**
         * JobView
         * @description A job as it is now.
         */
        JobView: {
            /**
             * Artifacts
             * @default []
             */
            artifacts: components["schemas"]["ArtifactView"][];
            /**
             * Attempt
             * @default 0
             */
            attempt: number;
            /** Batch Id */
            batch_id?: string | null;
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            error?: components["schemas"]["JobErrorView"] | null;
            /**
             * Event
             * @default 0
             */
            event: number;
            /**
             * Expired
             * @default false
             */
            expired: boolean;
            /** Expires At */
            expires_at?: string | null;
            /** Finished At */
            finished_at?: string | null;
            /**
             * Fraction
             * @default 0
             */
            fraction: number;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Inputs */
            inputs: {
                [key: string]: string[];
            };
            /** Kind */
            kind: string;
            /**
             * Message
             * @default
             */
            message: string;
            /**
             * Name
             * @default
             */
            name: string;
            /** Params */
            params: {
                [key: string]: unknown;
            };
            /**
             * Preview
             * @default 0
             */
            preview: number;
            /** Result */
            result?: {
                [key: string]: unknown;
            } | null;
            /**
             * Stage
             * @default
             */
            stage: string;
            /** Started At */
            started_at?: string | null;
            state: components["schemas"]["JobState"];
        };
        /**
         * KeyCreate
         * @description A request for an API key.
         */
        KeyCreate: {
            /** Expires At */
            expires_at?: string | null;
            /** Name */
            name: string;
            /**
             * Scopes
             * @default [
             *       "read",
             *       "write"
             *     ]
             */
            scopes: components["schemas"]["Scope"][];
        };
        /**
         * KeyCreated
         * @description An API key just made, the only time its secret is shown.
         */
        KeyCreated: {
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Expires At */
            expires_at?: string | null;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Last Used At */
            last_used_at?: string | null;
            /** Name */
            name: string;
            /** Prefix */
            prefix: string;
            /** Scopes */
            scopes: components["schemas"]["Scope"][];
            /** Secret */
            secret: string;
        };
        /**
         * KeyView
         * @description An API key without its secret.
         */
        KeyView: {
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Expires At */
            expires_at?: string | null;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Last Used At */
            last_used_at?: string | null;
            /** Name */
            name: string;
            /** Prefix */
            prefix: string;
            /** Scopes */
            scopes: components["schemas"]["Scope"][];
        };
        /**
         * LabelCount
         * @description A label, and how many shapes carry it.
         */
        LabelCount: {
            /** Name */
            name: string;
            /** Shapes */
            shapes: number;
            /** Value */
            value: string;
        };
        /**
         * LevelSummary
         * @description One level of the hierarchy; level 0 is the whole shape.
         */
        LevelSummary: {
            /** Edges */
            edges: [
                number,
                number
            ][];
            /** Level */
            level: number;
            /** Masses */
            masses: number[];
            /** Parents */
            parents: number[];
            /** Parts */
            parts: number;
        };
        /**
         * MeshChange
         * @description One step of the normalisation and how many elements it touched.
         */
        MeshChange: {
            /** Count */
            count: number;
            /** Name */
            name: string;
        };
        /**
         * Microhemorrhage
         * @description One cluster of bleeding.
         */
        Microhemorrhage: {
            /** Centroid */
            centroid: number[];
            /** Volume Mm3 */
            volume_mm3: number;
            /** Voxels */
            voxels: number;
        };
        /**
         * MotionDecodeParams
         * @description Which frames to decode, and into what.
         */
        MotionDecodeParams: {
            /**
             * First
             * @default 0
             */
            first: number;
            /**
             * Format
             * @default npz
             * @enum {string}
             */
            format: "npz" | "obj" | "ply" | "glb";
            /**
             * Stop
             * @default null
             */
            stop: number | null;
        };
        /**
         * MotionDecodeResult
         * @description What the API returns of a decoding.
         */
        MotionDecodeResult: {
            /** Bytes */
            bytes: number;
            /** Faces */
            faces: number;
            /** File */
            file: string;
            /** First */
            first: number;
            /**
             * Format
             * @enum {string}
             */
            format: "npz" | "obj" | "ply" | "glb";
            /** Frames */
            frames: number;
            /** Stages */
            stages: components["schemas"]["StageTime"][];
            /** Versions */
            versions: {
                [key: string]: string;
            };
            /** Vertices */
            vertices: number;
        };
        /**
         * MotionEncodeParams
         * @description How to compress a sequence. Every bound that is given is met by the decoded file; without any, ``kg`` is 0.1.
         */
        MotionEncodeParams: {
            /**
             * Clusters
             * @default null
             */
            clusters: number | null;
            /**
             * Fps
             * @default null
             */
            fps: number | null;
            /**
             * Group Frames
             * @default null
             */
            group_frames: number | null;
            /**
             * Key Frames
             * @default []
             */
            key_frames: number[];
            /**
             * Kg
             * @default null
             */
            kg: number | null;
            /**
             * Max Error
             * @default null
             */
            max_error: number | null;
            /**
             * Name
             * @default
             */
            name: string;
            /**
             * Preset
             * @default default
             * @enum {string}
             */
            preset: "default" | "fast";
            /**
             * Profile
             * @default trajectory
             * @enum {string}
             */
            profile: "trajectory" | "gradient";
            /**
             * Rmse
             * @default null
             */
            rmse: number | null;
            /**
             * Unit
             * @default
             */
            unit: string;
        };
        /**
         * MotionEncodeResult
         * @description What the API returns of an encoding.
         */
        MotionEncodeResult: {
            /** Bits Per Vertex Frame */
            bits_per_vertex_frame: number;
            /** Bounds */
            bounds: {
                [key: string]: number;
            };
            /** Bytes */
            bytes: number;
            /** Clusters */
            clusters: number;
            /** Connectivity Bits Per Vertex */
            connectivity_bits_per_vertex: number;
            errors: components["schemas"]["MotionErrors"];
            /** Faces */
            faces: number;
            /** File */
            file: string;
            /** Frames */
            frames: number;
            /** Groups */
            groups: number;
            /** Motion Bits Per Vertex Frame */
            motion_bits_per_vertex_frame: number;
            /** Parts */
            parts: {
                [key: string]: number;
            };
            /**
             * Preset
             * @enum {string}
             */
            preset: "default" | "fast";
            /**
             * Profile
             * @enum {string}
             */
            profile: "trajectory" | "gradient";
            /** Stages */
            stages: components["schemas"]["StageTime"][];
            /** Versions */
            versions: {
                [key: string]: string;
            };
            /** Vertices */
            vertices: number;
            /**
             * Warnings
             * @default []
             */
            warnings: string[];
        };
        /**
         * MotionErrors
         * @description How far the decoded file is from its original.
         */
        MotionErrors: {
            /** Kg Percent */
            kg_percent: number;
            /** Largest Fraction */
            largest_fraction: number;
            /** Prediction */
            prediction: number;
            /** Rmse Edges */
            rmse_edges: number;
        };
        /** Page[AssetView] */
        Page_AssetView_: {
            /** Items */
            items: components["schemas"]["AssetView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /** Page[BatchView] */
        Page_BatchView_: {
            /** Items */
            items: components["schemas"]["BatchView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /** Page[CollectionView] */
        Page_CollectionView_: {
            /** Items */
            items: components["schemas"]["CollectionView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /** Page[JobView] */
        Page_JobView_: {
            /** Items */
            items: components["schemas"]["JobView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /** Page[KeyView] */
        Page_KeyView_: {
            /** Items */
            items: components["schemas"]["KeyView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /** Page[ShapeView] */
        Page_ShapeView_: {
            /** Items */
            items: components["schemas"]["ShapeView"][];
            /** Next Cursor */
            next_cursor?: string | null;
        };
        /**
         * PartMatch
         * @description Two parts that the matching put together.
         */
        PartMatch: {
            /** Found */
            found: number;
            /** Query */
            query: number;
            /** Weight */
            weight: number;
        };
        /**
         * Problem
         * @description ``application/problem+json`` (RFC 9457) with a stable ``code``.
         */
        Problem: {
            /**
             * Code
             * @enum {string}
             */
            code: "bad_request" | "checksum_mismatch" | "conflict" | "corrupt_file" | "different_subjects" | "empty_content" | "forbidden" | "gone" | "grid_mismatch" | "headers_too_large" | "idempotency_conflict" | "inconsistent_sequence" | "input_expired" | "internal_error" | "invalid_mesh" | "invalid_params" | "invalid_transition" | "invalid_volume" | "irregular_series" | "length_required" | "memory_limit_exceeded" | "method_not_allowed" | "missing_dependency" | "missing_input" | "mixed_series" | "no_object_found" | "not_acceptable" | "not_found" | "precondition_failed" | "range_not_satisfiable" | "rate_limited" | "request_timeout" | "request_too_large" | "service_unavailable" | "storage_full" | "time_limit_exceeded" | "too_large" | "unauthenticated" | "unknown_format" | "unknown_job_kind" | "unsafe_archive" | "unsupported_format" | "unsupported_media_type" | "untrusted_host" | "untrusted_origin" | "upload_expired" | "upload_locked" | "upload_offset_mismatch" | "validation_failed" | "worker_lost" | "wrong_input_kind";
            /** Detail */
            detail: string;
            /** @description The places that are not valid (`validation_failed`). */
            errors?: components["schemas"]["FieldProblem"][];
            /**
             * Hint
             * @default
             */
            hint: string;
            /**
             * Instance
             * @default
             */
            instance: string;
            /**
             * Request Id
             * @default
             */
            request_id: string;
            /** Status */
            status: number;
            /** Title */
            title: string;
            /** Type */
            type: string;
        } & {
            [key: string]: unknown;
        };
        /**
         * ReadyView
         * @description Whether requests can be served.
         */
        ReadyView: {
            /** Checks */
            checks: {
                [key: string]: components["schemas"]["CheckView"];
            };
            /**
             * Status
             * @enum {string}
             */
            status: "ok" | "down";
        };
        /**
         * Scope
         * @description What an API key may do.
         * @enum {string}
         */
        Scope: "read" | "write" | "admin";
        /**
         * SearchAnswer
         * @description What a search found.
         */
        SearchAnswer: {
            /** Candidates */
            candidates: number;
            /** Cues */
            cues: {
                [key: string]: number;
            };
            /** Hits */
            hits: components["schemas"]["SearchHit"][];
            /** Index Version */
            index_version: number;
            /** Job Id */
            job_id?: string | null;
            /**
             * Mode
             * @enum {string}
             */
            mode: "global" | "partial";
            /**
             * Warnings
             * @default []
             */
            warnings: string[];
        };
        /**
         * SearchHit
         * @description One shape that was found, with what a viewer shows of it.
         */
        SearchHit: {
            /**
             * Cells
             * @default []
             */
            cells: number[];
            /** Level */
            level: number;
            /** Level Scores */
            level_scores: number[];
            /** Matches */
            matches: components["schemas"]["PartMatch"][];
            /** Score */
            score: number;
            shape: components["schemas"]["ShapeView"];
            /** Shape Id */
            shape_id: string;
        };
        /**
         * SearchRequest
         * @description A query by example: a stored shape, or an uploaded mesh.
         */
        SearchRequest: {
            /** Asset Id */
            asset_id?: string | null;
            /** Collection */
            collection?: string | null;
            /**
             * Labels
             * @default {}
             */
            labels: {
                [key: string]: string;
            };
            /**
             * Limit
             * @default 20
             */
            limit: number;
            /**
             * Mode
             * @default global
             * @enum {string}
             */
            mode: "global" | "partial";
            /** Parts */
            parts?: number[] | null;
            /** Region */
            region?: number[] | null;
            /**
             * Rerank
             * @default false
             */
            rerank: boolean;
            /** Shape Id */
            shape_id?: string | null;
        };
        /**
         * SegmentationParams
         * @description How to segment; every default is chosen so that two volumes alone suffice.
         */
        SegmentationParams: {
            /**
             * Box
             * @default null
             */
            box: number[] | null;
            /**
             * Edge Length
             * @default null
             */
            edge_length: number | null;
            /**
             * Max Objects
             * @default 8
             */
            max_objects: number;
            /**
             * Microhemorrhages
             * @default auto
             * @enum {string}
             */
            microhemorrhages: "auto" | "bright" | "dark" | "off";
            /**
             * Mode
             * @default auto
             * @enum {string}
             */
            mode: "auto" | "tumor" | "object";
            /**
             * Polarity
             * @default auto
             * @enum {string}
             */
            polarity: "auto" | "bright" | "dark";
            /**
             * Random Seed
             * @default 0
             */
            random_seed: number;
            /**
             * Register Volumes
             * @default true
             */
            register_volumes: boolean;
            /**
             * Seeds
             * @default []
             */
            seeds: number[][];
            /**
             * Smoothing
             * @default 0.12
             */
            smoothing: number;
            /**
             * Topology
             * @default adaptive
             * @enum {string}
             */
            topology: "preserve" | "adaptive";
            /**
             * Vessel Seeds
             * @default []
             */
            vessel_seeds: number[][];
        };
        /**
         * SegmentationResult
         * @description What ``report.json`` holds and the API returns.
         */
        SegmentationResult: {
            /**
             * Alignments
             * @default []
             */
            alignments: components["schemas"]["Alignment"][];
            /**
             * Microhemorrhages
             * @default []
             */
            microhemorrhages: components["schemas"]["Microhemorrhage"][];
            /**
             * Mode
             * @default tumor
             * @enum {string}
             */
            mode: "tumor" | "object";
            /** Objects */
            objects: components["schemas"]["SegmentedObject"][];
            /** Stages */
            stages: components["schemas"]["StageTime"][];
            /** Versions */
            versions: {
                [key: string]: string;
            };
            /**
             * Vessel Polarity
             * @default null
             */
            vessel_polarity: ("bright" | "dark") | null;
            /**
             * Vessels
             * @default []
             */
            vessels: components["schemas"]["SegmentedVessel"][];
            /** Voxel Counts */
            voxel_counts: {
                [key: string]: number;
            };
            /** Voxel Volume Mm3 */
            voxel_volume_mm3: number;
            /**
             * Warnings
             * @default []
             */
            warnings: string[];
        };
        /**
         * SegmentedObject
         * @description One recovered object.
         */
        SegmentedObject: {
            /** Area Mm2 */
            area_mm2: number;
            /** Centroid */
            centroid: number[];
            /** Closed */
            closed: boolean;
            /** Confidence */
            confidence: number;
            /** Converged */
            converged: boolean;
            /** Core Volume Mm3 */
            core_volume_mm3: number;
            /** Faces */
            faces: number;
            /** Genus */
            genus: number;
            /** Iterations */
            iterations: number;
            /** Label */
            label: number;
            /**
             * Notes
             * @default []
             */
            notes: string[];
            /**
             * Polarity
             * @default bright
             * @enum {string}
             */
            polarity: "bright" | "dark" | "between";
            /** Seed */
            seed: number[];
            /**
             * Seed Volume Mm3
             * @default 0
             */
            seed_volume_mm3: number;
            /**
             * Seeded By
             * @enum {string}
             */
            seeded_by: "automatic" | "user";
            /** Self Intersections */
            self_intersections: number;
            /** Surface */
            surface: string;
            /** Threshold */
            threshold: number;
            /** Vertices */
            vertices: number;
            /** Volume Mm3 */
            volume_mm3: number;
        };
        /**
         * SegmentedVessel
         * @description One connected vessel, with all its branches.
         */
        SegmentedVessel: {
            /** Area Mm2 */
            area_mm2: number;
            /** Branches */
            branches: number;
            /** Closed */
            closed: boolean;
            /** Faces */
            faces: number;
            /** Forks */
            forks: number;
            /** Genus */
            genus: number;
            /** Label */
            label: number;
            /** Largest Radius Mm */
            largest_radius_mm: number;
            /** Least Radius Mm */
            least_radius_mm: number;
            /** Length Mm */
            length_mm: number;
            /** Mean Radius Mm */
            mean_radius_mm: number;
            /** Self Intersections */
            self_intersections: number;
            /** Surface */
            surface: string;
            /** Vertices */
            vertices: number;
            /** Volume Mm3 */
            volume_mm3: number;
        };
        /**
         * ServerInfo
         * @description What ``GET /v1/info`` tells of the server: version, how one signs in, and the limits.
         */
        ServerInfo: {
            /**
             * Auth
             * @enum {string}
             */
            auth: "local" | "keys";
            /** Max Batch Items */
            max_batch_items: number;
            /** Max Upload Bytes */
            max_upload_bytes: number;
            /** Result Ttl Seconds */
            result_ttl_seconds: number;
            /** Upload Ttl Seconds */
            upload_ttl_seconds: number;
            /** Version */
            version: string;
        };
        /**
         * ShapeDetail
         * @description A shape with what indexing told of it.
         */
        ShapeDetail: {
            /** Area */
            area: number;
            /** Arg Url */
            arg_url: string;
            /**
             * Asset Id
             * Format: uuid
             */
            asset_id: string;
            /** Bounding Box */
            bounding_box: number[][];
            /** Changes */
            changes: components["schemas"]["MeshChange"][];
            /** Closed */
            closed: boolean;
            /** Collection */
            collection: string;
            /**
             * Collection Id
             * Format: uuid
             */
            collection_id: string;
            /** Components */
            components: number;
            /** Components Url */
            components_url: string;
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Faces */
            faces: number;
            /** Genus */
            genus: number | null;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Index Version */
            index_version: number;
            /**
             * Indexed At
             * Format: date-time
             */
            indexed_at: string;
            /**
             * Job Id
             * Format: uuid
             */
            job_id: string;
            /** Labels */
            labels: {
                [key: string]: string;
            };
            /** Levels */
            levels: components["schemas"]["LevelSummary"][];
            /** Mesh Url */
            mesh_url: string;
            /** Metadata */
            metadata: {
                [key: string]: unknown;
            };
            /** Name */
            name: string;
            /** Oriented */
            oriented: boolean;
            /** Outdated */
            outdated: boolean;
            /** Preview Url */
            preview_url: string;
            /** Vertices */
            vertices: number;
            /** Warnings */
            warnings: string[];
        };
        /**
         * ShapeFilter
         * @description Which shapes of the bank are asked for. The owner is no part of it: a bank shows one owner's shapes only.
         */
        ShapeFilter: {
            /**
             * Collection
             * @default null
             */
            collection: string | null;
            /**
             * Labels
             * @default {}
             */
            labels: {
                [key: string]: string;
            };
        };
        /**
         * ShapeHit
         * @description One shape that was found.
         */
        ShapeHit: {
            /**
             * Cells
             * @default []
             */
            cells: number[];
            /** Level */
            level: number;
            /** Level Scores */
            level_scores: number[];
            /** Matches */
            matches: components["schemas"]["PartMatch"][];
            /** Score */
            score: number;
            /** Shape Id */
            shape_id: string;
        };
        /**
         * ShapeIndexParams
         * @description How to index one mesh, and where the bank shall keep it.
         *
         *     What is compared later has no settings, so that all shapes of a bank are comparable.
         */
        ShapeIndexParams: {
            /**
             * Collection
             * @default default
             */
            collection: string;
            /**
             * Labels
             * @default {}
             */
            labels: {
                [key: string]: string;
            };
            /**
             * Metadata
             * @default {}
             */
            metadata: {
                [key: string]: unknown;
            };
            /**
             * Name
             * @default
             */
            name: string;
            /**
             * Preview Size
             * @default 256
             */
            preview_size: number;
            /**
             * Replaces
             * @default null
             */
            replaces: string | null;
        };
        /**
         * ShapeIndexResult
         * @description What ``report.json`` holds and the API returns.
         *
         *     Artifacts: ``shape.arg`` (the attributed relational graph), ``mesh.glb`` (for viewers), ``components.json`` (for
         *     each level the part of every vertex of ``mesh.glb``, the cell of each, of which parts consist, and how the shape
         *     stands: the axes to the right, up and to the front, and, along them, the direction to whoever looks),
         *     ``preview.png``, ``report.json``.
         */
        ShapeIndexResult: {
            /** Area */
            area: number;
            /**
             * Arg
             * @default shape.arg
             */
            arg: string;
            /** Arg Bytes */
            arg_bytes: number;
            /** Bounding Box */
            bounding_box: number[][];
            /** Changes */
            changes: components["schemas"]["MeshChange"][];
            /** Closed */
            closed: boolean;
            /** Components */
            components: number;
            /** Faces */
            faces: number;
            /** Genus */
            genus: number | null;
            /** Index Version */
            index_version: number;
            /** Levels */
            levels: components["schemas"]["LevelSummary"][];
            /** Oriented */
            oriented: boolean;
            /** Part Vector */
            part_vector: number[];
            /** Stages */
            stages: components["schemas"]["IndexStage"][];
            /** Vector */
            vector: number[];
            /** Vertices */
            vertices: number;
            /**
             * Warnings
             * @default []
             */
            warnings: string[];
        };
        /**
         * ShapeSearchParams
         * @description What to look for: a mesh (the input ``mesh``) or a stored shape, whole or a region of it.
         */
        ShapeSearchParams: {
            /**
             * @default {
             *       "collection": null,
             *       "labels": {}
             *     }
             */
            filter: components["schemas"]["ShapeFilter"];
            /**
             * Limit
             * @default 20
             */
            limit: number;
            /**
             * Mode
             * @default global
             * @enum {string}
             */
            mode: "global" | "partial";
            /**
             * Parts
             * @default null
             */
            parts: number[] | null;
            /**
             * Region
             * @default null
             */
            region: number[] | null;
            /**
             * Rerank
             * @default false
             */
            rerank: boolean;
            /**
             * Shape Id
             * @default null
             */
            shape_id: string | null;
        };
        /**
         * ShapeSearchResult
         * @description What a search answers.
         *
         *     Artifacts: ``results.json``; where a mesh was searched with, also its ``mesh.glb`` and ``components.json``.
         */
        ShapeSearchResult: {
            /** Candidates */
            candidates: number;
            /** Cues */
            cues: {
                [key: string]: number;
            };
            /** Hits */
            hits: components["schemas"]["ShapeHit"][];
            /** Index Version */
            index_version: number;
            /**
             * Mode
             * @enum {string}
             */
            mode: "global" | "partial";
            /** Stages */
            stages: components["schemas"]["IndexStage"][];
            /**
             * Warnings
             * @default []
             */
            warnings: string[];
        };
        /**
         * ShapeUpdate
         * @description What shall change of a shape; what is left out stays.
         */
        ShapeUpdate: {
            /** Collection */
            collection?: string | null;
            /** Labels */
            labels?: {
                [key: string]: string;
            } | null;
            /** Metadata */
            metadata?: {
                [key: string]: unknown;
            } | null;
            /** Name */
            name?: string | null;
        };
        /**
         * ShapeView
         * @description A shape of the bank.
         */
        ShapeView: {
            /** Area */
            area: number;
            /** Arg Url */
            arg_url: string;
            /**
             * Asset Id
             * Format: uuid
             */
            asset_id: string;
            /** Bounding Box */
            bounding_box: number[][];
            /** Closed */
            closed: boolean;
            /** Collection */
            collection: string;
            /**
             * Collection Id
             * Format: uuid
             */
            collection_id: string;
            /** Components */
            components: number;
            /** Components Url */
            components_url: string;
            /**
             * Created At
             * Format: date-time
             */
            created_at: string;
            /** Faces */
            faces: number;
            /** Genus */
            genus: number | null;
            /**
             * Id
             * Format: uuid
             */
            id: string;
            /** Index Version */
            index_version: number;
            /**
             * Indexed At
             * Format: date-time
             */
            indexed_at: string;
            /**
             * Job Id
             * Format: uuid
             */
            job_id: string;
            /** Labels */
            labels: {
                [key: string]: string;
            };
            /** Mesh Url */
            mesh_url: string;
            /** Metadata */
            metadata: {
                [key: string]: unknown;
            };
            /** Name */
            name: string;
            /** Oriented */
            oriented: boolean;
            /** Outdated */
            outdated: boolean;
            /** Preview Url */
            preview_url: string;
            /** Vertices */
            vertices: number;
        };
        /**
         * StageTime
         * @description How long one stage took.
         */
        StageTime: {
            /** Name */
            name: string;
            /** Seconds */
            seconds: number;
        };
        /**
         * StoredView
         * @description A number of files and how much they hold together.
         */
        StoredView: {
            /**
             * Bytes
             * @default 0
             */
            bytes: number;
            /**
             * Files
             * @default 0
             */
            files: number;
        };
        /**
         * UsageView
         * @description What ``GET /v1/usage`` tells: how many jobs one has in which state, and how much one keeps on the server.
         */
        UsageView: {
            /** Assets */
            assets: {
                [key: string]: components["schemas"]["StoredView"];
            };
            /** Jobs */
            jobs: {
                [key: string]: number;
            };
            results: components["schemas"]["StoredView"];
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    getHealth: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HealthView"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getMetrics: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Metrics as text. */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "text/plain": string;
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getReadiness: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ReadyView"];
                };
            };
            /** @description `service_unavailable`: A part of the platform that this needs does not answer. */
            503: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:service_unavailable",
                     *       "title": "A part of the platform that this needs does not answer.",
                     *       "status": 503,
                     *       "detail": "A part of the platform that this needs does not answer.",
                     *       "code": "service_unavailable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listAssets: {
        parameters: {
            query?: {
                /** @description `next_cursor` of the page before; leave it out for the first page. */
                cursor?: string | null;
                /** @description Only assets of this kind. */
                kind?: components["schemas"]["AssetKind"] | null;
                /** @description Items a page may have. */
                limit?: number;
                /** @description By what, upwards; downwards with a minus. */
                order?: "-created" | "created" | "name" | "-name";
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_AssetView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createAsset: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": {
                    /** Format: binary */
                    file: string;
                };
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AssetView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_timeout`: The client stayed silent for too long within its request. */
            408: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_timeout",
                     *       "title": "The client stayed silent for too long within its request.",
                     *       "status": 408,
                     *       "detail": "The client stayed silent for too long within its request.",
                     *       "code": "request_timeout",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unsupported_media_type`: The body has a content type that this resource does not take. */
            415: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unsupported_media_type",
                     *       "title": "The body has a content type that this resource does not take.",
                     *       "status": 415,
                     *       "detail": "The body has a content type that this resource does not take.",
                     *       "code": "unsupported_media_type",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unknown_format`: The file is of no format that is known here. `corrupt_file`: The file is damaged, truncated, or contradicts itself. `unsupported_format`: The file's format is known, but not this variant of it. `unsafe_archive`: The archive holds entries that no honest archive holds. `empty_content`: There is nothing in it to work on. `missing_input`: The job needs an input that was not given. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unknown_format",
                     *       "title": "The file is of no format that is known here.",
                     *       "status": 422,
                     *       "detail": "The file is of no format that is known here.",
                     *       "code": "unknown_format",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `storage_full`: The server's storage has no room for this. */
            507: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:storage_full",
                     *       "title": "The server's storage has no room for this.",
                     *       "status": 507,
                     *       "detail": "The server's storage has no room for this.",
                     *       "code": "storage_full",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getAsset: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                asset_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AssetView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    deleteAsset: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                asset_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getAssetContent: {
        parameters: {
            query?: never;
            header?: {
                /** @description Entity tags one of which the content must have. */
                "If-Match"?: string;
                /** @description Entity tags that the client has already. */
                "If-None-Match"?: string;
                /** @description Entity tag for which `Range` holds; with another the whole content comes. */
                "If-Range"?: string;
                /** @description Bytes to return: `bytes=0-1023`. */
                Range?: string;
            };
            path: {
                asset_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The whole content. */
            200: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The asked ranges: one as it is, several as `multipart/byteranges`. */
            206: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description Which bytes these are. */
                    "Content-Range"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The content is still the one of `If-None-Match`. */
            304: {
                headers: {
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `range_not_satisfiable`: The asked range lies outside the content. */
            416: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:range_not_satisfiable",
                     *       "title": "The asked range lies outside the content.",
                     *       "status": 416,
                     *       "detail": "The asked range lies outside the content.",
                     *       "code": "range_not_satisfiable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listBatches: {
        parameters: {
            query?: {
                /** @description `next_cursor` of the page before; leave it out for the first page. */
                cursor?: string | null;
                /** @description Items a page may have. */
                limit?: number;
                /** @description By what, upwards; downwards with a minus. */
                order?: "-created" | "created";
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_BatchView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createBatch: {
        parameters: {
            query?: never;
            header?: {
                /** @description Any text of your choice. A second request with the same key and the same body returns the first one's result; with another body it is refused. */
                "Idempotency-Key"?: string | null;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["BatchCreate"];
                /**
                 * @example {"kind": "segmentation", "params": {}}
                 *     {"inputs": {"post": "01890a5d-ac96-774b-bcce-b302099a8057"}}
                 *     {"inputs": {"post": "01890a5d-ac96-774b-bcce-b302099a8058"}, "params": {"max_objects": 2}}
                 */
                "application/x-ndjson": string;
            };
        };
        responses: {
            /** @description Successful Response */
            202: {
                headers: {
                    /** @description The batch's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_timeout`: The client stayed silent for too long within its request. */
            408: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_timeout",
                     *       "title": "The client stayed silent for too long within its request.",
                     *       "status": 408,
                     *       "detail": "The client stayed silent for too long within its request.",
                     *       "code": "request_timeout",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `idempotency_conflict`: The idempotency key was used before with another request. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:idempotency_conflict",
                     *       "title": "The idempotency key was used before with another request.",
                     *       "status": 409,
                     *       "detail": "The idempotency key was used before with another request.",
                     *       "code": "idempotency_conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. `too_large`: The content is larger than the limit. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unsupported_media_type`: The body has a content type that this resource does not take. */
            415: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unsupported_media_type",
                     *       "title": "The body has a content type that this resource does not take.",
                     *       "status": 415,
                     *       "detail": "The body has a content type that this resource does not take.",
                     *       "code": "unsupported_media_type",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. `unknown_job_kind`: There is no job of this kind. `invalid_params`: The job's parameters are not valid. `missing_input`: The job needs an input that was not given. `wrong_input_kind`: An input is of another kind than the job takes. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getBatch: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                batch_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancelBatch: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                batch_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    streamBatchEvents: {
        parameters: {
            query?: {
                /** @description Number of the last event received; all later ones follow. */
                after?: number | null;
            };
            header?: {
                /** @description The same as `after`, as browsers send it when they reconnect; it comes first. */
                "Last-Event-ID"?: string | null;
            };
            path: {
                batch_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Server-sent events: `id` is the sequence number, `event` is `counts`, `data` a `BatchEvent`. The stream ends when all jobs have. */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": {
                        data: string;
                        event: string;
                        id: string;
                        retry?: number;
                    };
                };
            };
            /** @description There is nothing more to come: the client need not ask again. */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `service_unavailable`: A part of the platform that this needs does not answer. */
            503: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:service_unavailable",
                     *       "title": "A part of the platform that this needs does not answer.",
                     *       "status": 503,
                     *       "detail": "A part of the platform that this needs does not answer.",
                     *       "code": "service_unavailable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    streamBatchResults: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                batch_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description One `BatchResult` per line, in the order of the items, also of jobs that have not ended. */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/x-ndjson": string;
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    retryBatch: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                batch_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listCollections: {
        parameters: {
            query?: {
                /** @description `next_cursor` of the page before; leave it out for the first page. */
                cursor?: string | null;
                /** @description Items a page may have. */
                limit?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_CollectionView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createCollection: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CollectionCreate"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    /** @description The collection's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CollectionView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `conflict`: The resource is not in a state in which this can be done. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:conflict",
                     *       "title": "The resource is not in a state in which this can be done.",
                     *       "status": 409,
                     *       "detail": "The resource is not in a state in which this can be done.",
                     *       "code": "conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getCollection: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                collection_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CollectionView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    deleteCollection: {
        parameters: {
            query?: {
                /** @description Whether its shapes are deleted with it; without, it must be empty. */
                shapes?: boolean;
            };
            header?: never;
            path: {
                collection_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `conflict`: The resource is not in a state in which this can be done. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:conflict",
                     *       "title": "The resource is not in a state in which this can be done.",
                     *       "status": 409,
                     *       "detail": "The resource is not in a state in which this can be done.",
                     *       "code": "conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    updateCollection: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                collection_id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CollectionUpdate"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CollectionView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `conflict`: The resource is not in a state in which this can be done. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:conflict",
                     *       "title": "The resource is not in a state in which this can be done.",
                     *       "status": 409,
                     *       "detail": "The resource is not in a state in which this can be done.",
                     *       "code": "conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    reindexCollection: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                collection_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            202: {
                headers: {
                    /** @description The batch's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `conflict`: The resource is not in a state in which this can be done. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:conflict",
                     *       "title": "The resource is not in a state in which this can be done.",
                     *       "status": 409,
                     *       "detail": "The resource is not in a state in which this can be done.",
                     *       "code": "conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `input_expired`: An input of the job has been deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:input_expired",
                     *       "title": "An input of the job has been deleted.",
                     *       "status": 410,
                     *       "detail": "An input of the job has been deleted.",
                     *       "code": "input_expired",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getInfo: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ServerInfo"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listJobs: {
        parameters: {
            query?: {
                /** @description Only jobs of this batch. */
                batch_id?: string | null;
                /** @description `next_cursor` of the page before; leave it out for the first page. */
                cursor?: string | null;
                /** @description Only jobs of this kind. */
                kind?: string | null;
                /** @description Items a page may have. */
                limit?: number;
                /** @description Only jobs with this text in their name. */
                name?: string | null;
                /** @description By what, upwards; downwards with a minus. */
                order?: "-created" | "created" | "name" | "-name" | "state" | "-state" | "took" | "-took";
                /** @description Only jobs in this state. */
                state?: components["schemas"]["JobState"] | null;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_JobView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createJob: {
        parameters: {
            query?: never;
            header?: {
                /** @description Any text of your choice. A second request with the same key and the same body returns the first one's result; with another body it is refused. */
                "Idempotency-Key"?: string | null;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["JobCreate"];
            };
        };
        responses: {
            /** @description Successful Response */
            202: {
                headers: {
                    /** @description The job's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `idempotency_conflict`: The idempotency key was used before with another request. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:idempotency_conflict",
                     *       "title": "The idempotency key was used before with another request.",
                     *       "status": 409,
                     *       "detail": "The idempotency key was used before with another request.",
                     *       "code": "idempotency_conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. `unknown_job_kind`: There is no job of this kind. `invalid_params`: The job's parameters are not valid. `missing_input`: The job needs an input that was not given. `wrong_input_kind`: An input is of another kind than the job takes. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getJob: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getArtifact: {
        parameters: {
            query?: never;
            header?: {
                /** @description Entity tags one of which the content must have. */
                "If-Match"?: string;
                /** @description Entity tags that the client has already. */
                "If-None-Match"?: string;
                /** @description Entity tag for which `Range` holds; with another the whole content comes. */
                "If-Range"?: string;
                /** @description Bytes to return: `bytes=0-1023`. */
                Range?: string;
            };
            path: {
                job_id: string;
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The whole content. */
            200: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The asked ranges: one as it is, several as `multipart/byteranges`. */
            206: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description Which bytes these are. */
                    "Content-Range"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The content is still the one of `If-None-Match`. */
            304: {
                headers: {
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `range_not_satisfiable`: The asked range lies outside the content. */
            416: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:range_not_satisfiable",
                     *       "title": "The asked range lies outside the content.",
                     *       "status": 416,
                     *       "detail": "The asked range lies outside the content.",
                     *       "code": "range_not_satisfiable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancelJob: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `invalid_transition`: The job is in a state that does not allow this. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:invalid_transition",
                     *       "title": "The job is in a state that does not allow this.",
                     *       "status": 409,
                     *       "detail": "The job is in a state that does not allow this.",
                     *       "code": "invalid_transition",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    streamJobEvents: {
        parameters: {
            query?: {
                /** @description Number of the last event received; all later ones follow. */
                after?: number | null;
            };
            header?: {
                /** @description The same as `after`, as browsers send it when they reconnect; it comes first. */
                "Last-Event-ID"?: string | null;
            };
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Server-sent events: `id` is the sequence number, `event` is `state` or `progress`, `data` a `JobEvent`. The stream ends with the event of a terminal state. */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": {
                        data: string;
                        event: string;
                        id: string;
                        retry?: number;
                    };
                };
            };
            /** @description There is nothing more to come: the client need not ask again. */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `service_unavailable`: A part of the platform that this needs does not answer. */
            503: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:service_unavailable",
                     *       "title": "A part of the platform that this needs does not answer.",
                     *       "status": 503,
                     *       "detail": "A part of the platform that this needs does not answer.",
                     *       "code": "service_unavailable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getJobPreview: {
        parameters: {
            query?: {
                /** @description Number of the preview that one has already. */
                after?: number;
            };
            header?: never;
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The newest preview. Of a segmentation: `evolution.bin` with one frame per object. */
            200: {
                headers: {
                    /** @description Its number: send it as `after` the next time. */
                    "Shapery-Preview"?: number;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description Nothing is newer than `after`, or the job does not run: look at its results. */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    retryJob: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `invalid_transition`: The job is in a state that does not allow this. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:invalid_transition",
                     *       "title": "The job is in a state that does not allow this.",
                     *       "status": 409,
                     *       "detail": "The job is in a state that does not allow this.",
                     *       "code": "invalid_transition",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `input_expired`: An input of the job has been deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:input_expired",
                     *       "title": "An input of the job has been deleted.",
                     *       "status": 410,
                     *       "detail": "An input of the job has been deleted.",
                     *       "code": "input_expired",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listKeys: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_KeyView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createKey: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["KeyCreate"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["KeyCreated"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    deleteKey: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                key_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listKinds: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobKindView"][];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listShapeLabels: {
        parameters: {
            query?: {
                /** @description Only of the collection of this name. */
                collection?: string | null;
                /** @description Items a page may have. */
                limit?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LabelCount"][];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    search: {
        parameters: {
            query?: {
                /** @description Seconds to wait for the answer before a job is shown. */
                wait?: number;
            };
            header?: {
                /** @description Any text of your choice. A second request with the same key and the same body returns the first one's result; with another body it is refused. */
                "Idempotency-Key"?: string | null;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SearchRequest"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SearchAnswer"];
                };
            };
            /** @description The job that searches; its address is `Location`, that of the answer `/v1/search/{job_id}`. */
            202: {
                headers: {
                    /** @description The job's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `idempotency_conflict`: The idempotency key was used before with another request. `conflict`: The resource is not in a state in which this can be done. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:idempotency_conflict",
                     *       "title": "The idempotency key was used before with another request.",
                     *       "status": 409,
                     *       "detail": "The idempotency key was used before with another request.",
                     *       "code": "idempotency_conflict",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `input_expired`: An input of the job has been deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:input_expired",
                     *       "title": "An input of the job has been deleted.",
                     *       "status": 410,
                     *       "detail": "An input of the job has been deleted.",
                     *       "code": "input_expired",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. `unknown_job_kind`: There is no job of this kind. `invalid_params`: The job's parameters are not valid. `missing_input`: The job needs an input that was not given. `wrong_input_kind`: An input is of another kind than the job takes. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `service_unavailable`: A part of the platform that this needs does not answer. */
            503: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:service_unavailable",
                     *       "title": "A part of the platform that this needs does not answer.",
                     *       "status": 503,
                     *       "detail": "A part of the platform that this needs does not answer.",
                     *       "code": "service_unavailable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getSearch: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SearchAnswer"];
                };
            };
            /** @description The job that searches; its address is `Location`, that of the answer `/v1/search/{job_id}`. */
            202: {
                headers: {
                    /** @description The job's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    listShapes: {
        parameters: {
            query?: {
                /** @description Only shapes of the collection of this name. */
                collection?: string | null;
                /** @description `next_cursor` of the page before; leave it out for the first page. */
                cursor?: string | null;
                /** @description Only the shape that this job has indexed last. */
                job_id?: string | null;
                /** @description Only shapes with this label, as `name:value`; all, where several. */
                label?: string[];
                /** @description Items a page may have. */
                limit?: number;
                /** @description Only shapes with this text in their name. */
                name?: string | null;
                /** @description By what, upwards; downwards with a minus. */
                order?: "-created" | "created" | "name" | "-name";
                /** @description Only shapes that an older version has indexed, which searches do not see. */
                outdated?: boolean;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_ShapeView_"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getShape: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                shape_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ShapeDetail"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    deleteShape: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                shape_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    updateShape: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                shape_id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ShapeUpdate"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ShapeDetail"];
                };
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getShapeFile: {
        parameters: {
            query?: never;
            header?: {
                /** @description Entity tags one of which the content must have. */
                "If-Match"?: string;
                /** @description Entity tags that the client has already. */
                "If-None-Match"?: string;
                /** @description Entity tag for which `Range` holds; with another the whole content comes. */
                "If-Range"?: string;
                /** @description Bytes to return: `bytes=0-1023`. */
                Range?: string;
            };
            path: {
                file: "arg" | "mesh.glb" | "preview.png" | "components";
                shape_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The whole content. */
            200: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The asked ranges: one as it is, several as `multipart/byteranges`. */
            206: {
                headers: {
                    "Accept-Ranges"?: "bytes";
                    "Content-Disposition"?: string;
                    /** @description Which bytes these are. */
                    "Content-Range"?: string;
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "*/*": unknown;
                };
            };
            /** @description The content is still the one of `If-None-Match`. */
            304: {
                headers: {
                    /** @description The SHA-256 of the content, quoted. */
                    ETag?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `range_not_satisfiable`: The asked range lies outside the content. */
            416: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:range_not_satisfiable",
                     *       "title": "The asked range lies outside the content.",
                     *       "status": 416,
                     *       "detail": "The asked range lies outside the content.",
                     *       "code": "range_not_satisfiable",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    reindexShape: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                shape_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            202: {
                headers: {
                    /** @description The job's address. */
                    Location?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `input_expired`: An input of the job has been deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:input_expired",
                     *       "title": "An input of the job has been deleted.",
                     *       "status": 410,
                     *       "detail": "An input of the job has been deleted.",
                     *       "code": "input_expired",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    createUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description The version of the protocol. */
                "Tus-Resumable": "1.0.0";
                /** @description `sha256` and the body's digest in base64. */
                "Upload-Checksum"?: string;
                /** @description `1`: the length is told later. */
                "Upload-Defer-Length"?: "1";
                /** @description Bytes of the whole file. */
                "Upload-Length"?: string;
                /** @description `filename` and its name in base64. */
                "Upload-Metadata"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/offset+octet-stream": string;
            };
        };
        responses: {
            /** @description The upload's address. */
            201: {
                headers: {
                    Location?: string;
                    /** @description The asset that a finished upload became. */
                    "Upload-Asset-Id"?: string;
                    /** @description When an unfinished upload is removed. */
                    "Upload-Expires"?: string;
                    /** @description Bytes the server has. */
                    "Upload-Offset"?: number;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_timeout`: The client stayed silent for too long within its request. */
            408: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_timeout",
                     *       "title": "The client stayed silent for too long within its request.",
                     *       "status": 408,
                     *       "detail": "The client stayed silent for too long within its request.",
                     *       "code": "request_timeout",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_offset_mismatch`: The upload continues at another offset than the one given. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_offset_mismatch",
                     *       "title": "The upload continues at another offset than the one given.",
                     *       "status": 409,
                     *       "detail": "The upload continues at another offset than the one given.",
                     *       "code": "upload_offset_mismatch",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. `too_large`: The content is larger than the limit. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unsupported_media_type`: The body has a content type that this resource does not take. */
            415: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unsupported_media_type",
                     *       "title": "The body has a content type that this resource does not take.",
                     *       "status": 415,
                     *       "detail": "The body has a content type that this resource does not take.",
                     *       "code": "unsupported_media_type",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unknown_format`: The file is of no format that is known here. `corrupt_file`: The file is damaged, truncated, or contradicts itself. `unsupported_format`: The file's format is known, but not this variant of it. `unsafe_archive`: The archive holds entries that no honest archive holds. `empty_content`: There is nothing in it to work on. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unknown_format",
                     *       "title": "The file is of no format that is known here.",
                     *       "status": 422,
                     *       "detail": "The file is of no format that is known here.",
                     *       "code": "unknown_format",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_locked`: Another request is writing to this upload. */
            423: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_locked",
                     *       "title": "Another request is writing to this upload.",
                     *       "status": 423,
                     *       "detail": "Another request is writing to this upload.",
                     *       "code": "upload_locked",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `checksum_mismatch`: The bytes that arrived do not have the checksum that was sent with them. */
            460: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:checksum_mismatch",
                     *       "title": "The bytes that arrived do not have the checksum that was sent with them.",
                     *       "status": 460,
                     *       "detail": "The bytes that arrived do not have the checksum that was sent with them.",
                     *       "code": "checksum_mismatch",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `storage_full`: The server's storage has no room for this. */
            507: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:storage_full",
                     *       "title": "The server's storage has no room for this.",
                     *       "status": 507,
                     *       "detail": "The server's storage has no room for this.",
                     *       "code": "storage_full",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getUploadCapabilities: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Told in headers. */
            204: {
                headers: {
                    "Tus-Extension"?: string;
                    "Tus-Version"?: string;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    deleteUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description The version of the protocol. */
                "Tus-Resumable": "1.0.0";
            };
            path: {
                upload_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_locked`: Another request is writing to this upload. */
            423: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_locked",
                     *       "title": "Another request is writing to this upload.",
                     *       "status": 423,
                     *       "detail": "Another request is writing to this upload.",
                     *       "code": "upload_locked",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description The version of the protocol. */
                "Tus-Resumable": "1.0.0";
            };
            path: {
                upload_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Told in headers. */
            200: {
                headers: {
                    /** @description The asset that a finished upload became. */
                    "Upload-Asset-Id"?: string;
                    /** @description When an unfinished upload is removed. */
                    "Upload-Expires"?: string;
                    "Upload-Length"?: number;
                    /** @description Bytes the server has. */
                    "Upload-Offset"?: number;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_expired`: The upload was not finished in time and has been removed. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_expired",
                     *       "title": "The upload was not finished in time and has been removed.",
                     *       "status": 410,
                     *       "detail": "The upload was not finished in time and has been removed.",
                     *       "code": "upload_expired",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `validation_failed`: The request does not have the form it must have. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:validation_failed",
                     *       "title": "The request does not have the form it must have.",
                     *       "status": 422,
                     *       "detail": "The request does not have the form it must have.",
                     *       "code": "validation_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    appendToUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description The version of the protocol. */
                "Tus-Resumable": "1.0.0";
                /** @description `sha256` and the body's digest in base64. */
                "Upload-Checksum"?: string;
                /** @description Bytes of the whole file, if they were not told before. */
                "Upload-Length"?: string;
                /** @description Where the bytes begin. */
                "Upload-Offset": string;
            };
            path: {
                upload_id: string;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/offset+octet-stream": string;
            };
        };
        responses: {
            /** @description Taken in. */
            204: {
                headers: {
                    /** @description The asset that a finished upload became. */
                    "Upload-Asset-Id"?: string;
                    /** @description When an unfinished upload is removed. */
                    "Upload-Expires"?: string;
                    /** @description Bytes the server has. */
                    "Upload-Offset"?: number;
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description `bad_request`: The request cannot be understood. */
            400: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:bad_request",
                     *       "title": "The request cannot be understood.",
                     *       "status": 400,
                     *       "detail": "The request cannot be understood.",
                     *       "code": "bad_request",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `not_found`: There is no such resource, or it is not yours. */
            404: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:not_found",
                     *       "title": "There is no such resource, or it is not yours.",
                     *       "status": 404,
                     *       "detail": "There is no such resource, or it is not yours.",
                     *       "code": "not_found",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_timeout`: The client stayed silent for too long within its request. */
            408: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_timeout",
                     *       "title": "The client stayed silent for too long within its request.",
                     *       "status": 408,
                     *       "detail": "The client stayed silent for too long within its request.",
                     *       "code": "request_timeout",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_offset_mismatch`: The upload continues at another offset than the one given. */
            409: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_offset_mismatch",
                     *       "title": "The upload continues at another offset than the one given.",
                     *       "status": 409,
                     *       "detail": "The upload continues at another offset than the one given.",
                     *       "code": "upload_offset_mismatch",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `gone`: The resource existed and has expired or was deleted. */
            410: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:gone",
                     *       "title": "The resource existed and has expired or was deleted.",
                     *       "status": 410,
                     *       "detail": "The resource existed and has expired or was deleted.",
                     *       "code": "gone",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `precondition_failed`: A precondition given in the request's headers does not hold. */
            412: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:precondition_failed",
                     *       "title": "A precondition given in the request's headers does not hold.",
                     *       "status": 412,
                     *       "detail": "A precondition given in the request's headers does not hold.",
                     *       "code": "precondition_failed",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `request_too_large`: The body is larger than this server accepts. `too_large`: The content is larger than the limit. */
            413: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:request_too_large",
                     *       "title": "The body is larger than this server accepts.",
                     *       "status": 413,
                     *       "detail": "The body is larger than this server accepts.",
                     *       "code": "request_too_large",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unsupported_media_type`: The body has a content type that this resource does not take. */
            415: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unsupported_media_type",
                     *       "title": "The body has a content type that this resource does not take.",
                     *       "status": 415,
                     *       "detail": "The body has a content type that this resource does not take.",
                     *       "code": "unsupported_media_type",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `unknown_format`: The file is of no format that is known here. `corrupt_file`: The file is damaged, truncated, or contradicts itself. `unsupported_format`: The file's format is known, but not this variant of it. `unsafe_archive`: The archive holds entries that no honest archive holds. `empty_content`: There is nothing in it to work on. */
            422: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unknown_format",
                     *       "title": "The file is of no format that is known here.",
                     *       "status": 422,
                     *       "detail": "The file is of no format that is known here.",
                     *       "code": "unknown_format",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `upload_locked`: Another request is writing to this upload. */
            423: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:upload_locked",
                     *       "title": "Another request is writing to this upload.",
                     *       "status": 423,
                     *       "detail": "Another request is writing to this upload.",
                     *       "code": "upload_locked",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `checksum_mismatch`: The bytes that arrived do not have the checksum that was sent with them. */
            460: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:checksum_mismatch",
                     *       "title": "The bytes that arrived do not have the checksum that was sent with them.",
                     *       "status": 460,
                     *       "detail": "The bytes that arrived do not have the checksum that was sent with them.",
                     *       "code": "checksum_mismatch",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `storage_full`: The server's storage has no room for this. */
            507: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:storage_full",
                     *       "title": "The server's storage has no room for this.",
                     *       "status": 507,
                     *       "detail": "The server's storage has no room for this.",
                     *       "code": "storage_full",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    getUsage: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["UsageView"];
                };
            };
            /** @description `unauthenticated`: An API key is needed, and none or an unknown one was given. */
            401: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:unauthenticated",
                     *       "title": "An API key is needed, and none or an unknown one was given.",
                     *       "status": 401,
                     *       "detail": "An API key is needed, and none or an unknown one was given.",
                     *       "code": "unauthenticated",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `forbidden`: The API key has no scope that allows this. */
            403: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:forbidden",
                     *       "title": "The API key has no scope that allows this.",
                     *       "status": 403,
                     *       "detail": "The API key has no scope that allows this.",
                     *       "code": "forbidden",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description `rate_limited`: Too many requests in a short time. */
            429: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:rate_limited",
                     *       "title": "Too many requests in a short time.",
                     *       "status": 429,
                     *       "detail": "Too many requests in a short time.",
                     *       "code": "rate_limited",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Any other error. */
            default: {
                headers: {
                    /** @description The id under which the request is logged; the one that was sent, if it was well-formed. */
                    "X-Request-Id"?: string;
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example {
                     *       "type": "urn:shapery:problem:internal_error",
                     *       "title": "The fault is ours; it was logged under the given request id.",
                     *       "status": 500,
                     *       "detail": "The fault is ours; it was logged under the given request id.",
                     *       "code": "internal_error",
                     *       "hint": "",
                     *       "instance": "/v1/…",
                     *       "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a"
                     *     }
                     */
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
