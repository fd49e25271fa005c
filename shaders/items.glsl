// The item of each lane of a dispatch over any number of them: work groups go on in z where x may not
// be as many.
const uint kItemLanes = 64u;
uint group_of_items() { return gl_WorkGroupID.z * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint item_of_lane() { return group_of_items() * kItemLanes + gl_LocalInvocationIndex; }
