/PROG  USER_ALARM
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[1]=1 ;
   2:  UALM[1] ;
   3:  R[1]=2 ;
   4:  R[3]=2 ;
   5:  UALM[R[3]] ;
   6:  R[1]=3 ;
/POS
/END
--> continue
